#version 330 core
#include "lib/harmonics.glsl"

uniform samplerCube sky;

out vec3 coefficient;   // of the harmonic with the pixel's number

// The direction of a place on one of the six faces, each coordinate within −1 … 1.
vec3 towards(int face, vec2 at)
{
    vec3 side = face < 2 ? vec3(1.0, at) : face < 4 ? vec3(at.x, 1.0, at.y) : vec3(at, 1.0);
    return (face & 1) == 0 ? side : -side;
}

void main()
{
    int number = int(gl_FragCoord.x);
    int size = textureSize(sky, 0).x;
    float covered = 0.0;
    vec3 sum = vec3(0.0);
    for (int k = 0; k < 6 * size * size; ++k) {
        vec2 texel = vec2(k % size, k / size % size);
        vec3 direction = towards(k / (size * size), (2.0 * texel + 1.0) / float(size) - 1.0);
        // A texel in a corner is farther away and aslant: it covers less of the sky.
        float distance2 = dot(direction, direction);
        float solidAngle = 1.0 / (distance2 * sqrt(distance2));
        covered += solidAngle;
        vec3 light = textureLod(sky, direction, 0.0).rgb;
        sum += solidAngle * harmonic(number, normalize(direction)) * light;
    }
    coefficient = 12.566371 / covered * sum;
}
