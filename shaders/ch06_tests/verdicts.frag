#version 330 core
#include "lib/verdict.glsl"

in vec2 place;   // fields of the table from its lower left corner

uniform sampler2D values;   // a texel a field: 1 where a test let a draw through
uniform vec2 group;         // fields that belong together, across and up

out vec4 FragColor;

void main()
{
    vec3 color = verdictField(fract(place) * 2.0 - 1.0, texelFetch(values, ivec2(place), 0).r);
    vec2 edge = group * abs(fract(place / group + 0.5) - 0.5);
    float gap = step(min(edge.x, edge.y), 0.16);
    FragColor = vec4(mix(color, vec3(0.08, 0.09, 0.11), gap), 1.0);
}
