#version 330 core
#include "lib/studio.glsl"

in vec3 Normal;
in vec3 Color;

out vec4 FragColor;

void main()
{
    FragColor = vec4(studio(Color, Normal), 1.0);
}
