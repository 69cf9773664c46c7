#version 330 core
layout (location = 0) in vec3 aPos;
uniform float level;

void main()
{
    gl_Position = vec4(aPos * level, 1.0);
}
