#version 330 core
#include "lib/block_light.glsl"

in vec3 Normal;

out vec4 FragColor;

void main()
{
    FragColor = vec4(lit(vec3(0.12, 0.30, 0.78), Normal), 1.0);
}
