#version 330 core
layout (location = 0) in vec4 aPos;   // clip coordinates

out vec4 place;

void main()
{
    place = aPos;
    gl_Position = aPos;
}
