#version 330 core
layout (location = 0) in vec2 aPos;   // in device coordinates

uniform float size;   // of points, in pixels

void main()
{
    gl_Position = vec4(aPos, 0.0, 1.0);
    gl_PointSize = size;
}
