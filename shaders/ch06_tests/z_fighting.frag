#version 330 core
uniform vec3 color;
uniform float number;   // 1 for the wall in front, 2 for that behind

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float winner;

void main()
{
    FragColor = vec4(color, 1.0);
    winner = number;
}
