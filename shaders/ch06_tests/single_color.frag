#version 330 core
uniform vec3 color;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float outline;   // 1 wherever this draw reaches

void main()
{
    FragColor = vec4(color, 1.0);
    outline = 1.0;
}
