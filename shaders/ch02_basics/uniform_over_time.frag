#version 330 core
uniform vec4 ourColor;   // computed by the program that draws
uniform float time;      // in seconds

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float green;

void main()
{
    FragColor = ourColor;
    green = sin(time) / 2.0 + 0.5;   // the same law, computed here
}
