#version 330 core
#include "lib/look_at.glsl"
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform float angle;    // around y, from +z towards +x
uniform float radius;
uniform float height;
uniform mat4 projection;

out vec3 Normal;
out vec3 Color;
out vec3 Eye;

void main()
{
    Eye = vec3(radius * sin(angle), height, radius * cos(angle));
    mat4 view = lookAt(Eye, vec3(0.0, 0.4, 0.0), vec3(0.0, 1.0, 0.0));

    Normal = aNormal;
    Color = aColor;
    gl_Position = projection * (view * vec4(aPos, 1.0));
}
