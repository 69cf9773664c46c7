#version 330 core
layout (location = 0) in vec2 aPos;
layout (location = 1) in vec2 aOffset;   // once an instance
layout (location = 2) in vec3 aTint;     // once an instance

flat out vec3 Color;

void main()
{
    gl_Position = vec4(aPos + aOffset, 0.0, 1.0);
    Color = aTint;
}
