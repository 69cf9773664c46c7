#version 330 core
#include "lib/glass.glsl"

in vec2 place;

uniform Petal petal;
uniform float pixel;      // how wide one is

layout (location = 0) out vec4 color;
layout (location = 1) out float depth;

void main()
{
    color = vec4(petal.color, cover(petal, place, pixel));
    depth = depthOf(petal, place);
}
