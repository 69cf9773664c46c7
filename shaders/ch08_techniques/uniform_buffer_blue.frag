#version 330 core
#include "ch08_techniques/uniform_buffer_light.glsl"

in vec3 Normal;

out vec4 FragColor;

void main()
{
    FragColor = vec4(lit(vec3(0.12, 0.30, 0.78), Normal), 1.0);
}
