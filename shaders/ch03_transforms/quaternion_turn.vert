#version 330 core
#include "lib/quaternion.glsl"
layout (location = 0) in vec3 aPos;

uniform vec4 q;

out vec3 Turned;

void main()
{
    Turned = turned(aPos, q);
    gl_Position = vec4(Turned, 2.0);
}
