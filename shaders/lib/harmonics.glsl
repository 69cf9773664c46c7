// Real spherical harmonics up to the second order, numbered (0,0), (1,−1) … (1,1), (2,−2) … (2,2).

float harmonic(int number, vec3 d)
{
    float values[9] = float[](
        0.282095,
        0.488603 * d.y, 0.488603 * d.z, 0.488603 * d.x,
        1.092548 * (d.x * d.y), 1.092548 * (d.y * d.z), 0.315392 * (3.0 * d.z * d.z - 1.0),
        1.092548 * (d.x * d.z), 0.546274 * (d.x * d.x - d.y * d.y));
    return values[number];
}

// What a cosine makes of each order: π, 2π/3, π/4.
float smoothing(int number)
{
    return number == 0 ? 3.141593 : number < 4 ? 2.094395 : 0.785398;
}
