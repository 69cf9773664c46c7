#version 330 core
#include "lib/block_light.glsl"

in vec3 Normal;

out vec4 FragColor;

void main()
{
    FragColor = vec4(lit(vec3(0.16, 0.55, 0.22), Normal), 1.0);
}
