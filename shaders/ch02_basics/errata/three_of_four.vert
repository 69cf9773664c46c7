#version 330 core
layout (location = 0) in vec3 aPos;

out vec3 color;

void main()
{
    color = 0.5 + aPos;
    gl_Position = aPos;
}
