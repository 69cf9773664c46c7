#version 330 core
#include "folder.frag/colour.glsl"
out vec4 FragColor;

void main()
{
    FragColor = colour();
}
