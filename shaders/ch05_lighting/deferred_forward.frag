#version 330 core
#include "lib/lamps.glsl"

in vec3 FragPos;
in vec3 Normal;
in vec3 Color;

uniform Lamp lamps[LAMPS];
uniform vec3 viewPos;

out vec4 FragColor;

void main()
{
    vec3 normal = normalize(Normal);
    vec3 light = 0.03 * Color;
    for (int i = 0; i < LAMPS; ++i)
        light += fromLamp(lamps[i], FragPos, normal, Color, 0.8 * Color.r, viewPos);
    FragColor = vec4(light, 1.0);
}
