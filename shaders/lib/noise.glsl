// Noise on a lattice: the same place gives the same number, and near places give near numbers.

// M. O'Neill's PCG as a hash (Jarzynski & Olano 2020): exact on every device.
uint pcg(uint seed)
{
    uint state = seed * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

uint latticeHash(ivec2 corner)
{
    return pcg(uint(corner.x) + pcg(uint(corner.y)));
}

// K. Perlin's curve: slope and curvature are 0 at both ends.
vec2 faded(vec2 part)
{
    return part * part * part * (part * (part * 6.0 - 15.0) + 10.0);
}

float valueAt(ivec2 corner)
{
    return float(latticeHash(corner) >> 8u) / 8388608.0 - 1.0;
}

// Mixed from random numbers at the lattice points, −1 … 1.
float valueNoise(vec2 place)
{
    ivec2 corner = ivec2(floor(place));
    vec2 part = faded(fract(place));
    float lower = mix(valueAt(corner), valueAt(corner + ivec2(1, 0)), part.x);
    float upper = mix(valueAt(corner + ivec2(0, 1)), valueAt(corner + ivec2(1, 1)), part.x);
    return mix(lower, upper, part.y);
}

const vec2 SLOPES[8] = vec2[](
    vec2(1.0, 0.0), vec2(0.0, 1.0), vec2(-1.0, 0.0), vec2(0.0, -1.0),
    vec2(0.70710678, 0.70710678), vec2(-0.70710678, 0.70710678),
    vec2(-0.70710678, -0.70710678), vec2(0.70710678, -0.70710678));

float slopeAt(ivec2 corner, vec2 off)
{
    return dot(SLOPES[latticeHash(corner) & 7u], off);
}

// Mixed from random slopes at the lattice points, where it is 0; within ±√½.
float gradientNoise(vec2 place)
{
    ivec2 corner = ivec2(floor(place));
    vec2 off = fract(place);
    vec2 part = faded(off);
    float lower = mix(slopeAt(corner, off), slopeAt(corner + ivec2(1, 0), off - vec2(1.0, 0.0)), part.x);
    float upper = mix(slopeAt(corner + ivec2(0, 1), off - vec2(0.0, 1.0)),
                      slopeAt(corner + ivec2(1, 1), off - 1.0), part.x);
    return mix(lower, upper, part.y);
}

// Four octaves: each twice as fine and half as strong.
float octaves(vec2 place)
{
    float sum = 0.0;
    float strength = 1.0;
    for (int k = 0; k < 4; ++k) {
        sum += strength * gradientNoise(place);
        place = 2.0 * place + 17.5;
        strength *= 0.5;
    }
    return sum;
}
