#version 330 core
layout (location = 0) in vec2 aPos;   // in pixels of a target

uniform vec2 size;   // of that target

void main()
{
    gl_Position = vec4(2.0 * aPos / size - 1.0, 0.0, 1.0);
}
