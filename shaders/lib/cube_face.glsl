// The face of a cube map that a direction meets (0 to 5 for +X, -X, +Y, -Y, +Z, -Z), and s and t
// on it, by OpenGL's table of cube map images. Where two components are equal, x goes before y,
// and y before z.
vec3 cubeFace(vec3 direction)
{
    vec3 magnitude = abs(direction);
    float largest = max(max(magnitude.x, magnitude.y), magnitude.z);
    float face;
    vec2 place;
    if (magnitude.x >= magnitude.y && magnitude.x >= magnitude.z) {
        face = direction.x > 0.0 ? 0.0 : 1.0;
        place = vec2(direction.x > 0.0 ? -direction.z : direction.z, -direction.y);
    } else if (magnitude.y >= magnitude.z) {
        face = direction.y > 0.0 ? 2.0 : 3.0;
        place = vec2(direction.x, direction.y > 0.0 ? direction.z : -direction.z);
    } else {
        face = direction.z > 0.0 ? 4.0 : 5.0;
        place = vec2(direction.z > 0.0 ? direction.x : -direction.x, -direction.y);
    }
    return vec3(face, 0.5 * (place / largest + 1.0));
}
