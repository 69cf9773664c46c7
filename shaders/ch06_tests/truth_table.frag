#version 330 core
#include "lib/verdict.glsl"

in vec2 place;

uniform float verdict;   // what to write where the test lets this draw through

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float passed;

void main()
{
    FragColor = vec4(verdictField(fract(place) * 2.0 - 1.0, verdict), 1.0);
    passed = verdict;
}
