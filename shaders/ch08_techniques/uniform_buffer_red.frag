#version 330 core
#include "lib/block_light.glsl"

in vec3 Normal;

out vec4 FragColor;

void main()
{
    FragColor = vec4(lit(vec3(0.80, 0.16, 0.12), Normal), 1.0);
}
