#version 330 core
#include "lib/drawing.glsl"

in vec2 place;

out vec4 FragColor;

void main()
{
    vec3 paper = mix(vec3(0.75), vec3(0.95), chessboard(place * 6.0));
    FragColor = vec4(paper, 1.0);
}
