#version 330 core
#include "lib/noise.glsl"

layout (location = 0) out uint hashed;
layout (location = 1) out float permuted;

void main()
{
    float x = floor(gl_FragCoord.x);
    hashed = pcg(uint(x) * 2654435761u);
    // S. Gustavson's permutation of 0 … 288, for devices without integers.
    float product = (34.0 * x + 1.0) * x;
    permuted = product - 289.0 * floor(product / 289.0);
}
