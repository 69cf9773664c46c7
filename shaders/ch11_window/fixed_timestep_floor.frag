#version 330 core
#include "lib/drawing.glsl"

in float height;

out vec4 FragColor;

void main()
{
    vec3 color = height < 0.0 ? vec3(0.10, 0.11, 0.13) : vec3(0.025, 0.032, 0.045);
    FragColor = vec4(encoded(color), 1.0);
}
