#version 330 core
#include "lib/split_sum.glsl"

layout (location = 0) out uint fraction;

void main()
{
    // Numbers that have all of the 32 bits in use.
    fraction = reversed(uint(gl_FragCoord.x) * 2654435761u);
}
