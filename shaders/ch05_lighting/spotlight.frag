#version 330 core
#include "lib/spotlight.glsl"

in vec3 FragPos;

uniform Spot light;

layout (location = 0) out float intensity;
layout (location = 1) out float ratio;

void main()
{
    ratio = spotRatio(light, FragPos);
    intensity = spotIntensity(light, FragPos);
}
