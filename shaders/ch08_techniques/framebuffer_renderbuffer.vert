#version 330 core
layout (location = 0) in vec3 aPos;

uniform float size;
uniform float depth;

void main()
{
    gl_Position = vec4(size * aPos.xy, depth, 1.0);
}
