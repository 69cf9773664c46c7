#version 330 core
#include "lib/verdict.glsl"

in vec2 place;

uniform float block;     // side of a group of fields, in pixels
uniform float verdict;   // what to write where the test lets this draw through

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float passed;

void main()
{
    vec2 edge = abs(mod(gl_FragCoord.xy + 0.5 * block, block) - 0.5 * block);
    float gap = step(min(edge.x, edge.y), 2.0);
    vec3 color = verdictField(fract(place) * 2.0 - 1.0, verdict);
    FragColor = vec4(mix(color, vec3(0.08, 0.09, 0.11), gap), 1.0);
    passed = verdict;
}
