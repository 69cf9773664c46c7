#version 330 core
#include "lib/spotlight.glsl"

in float tangent;   // of the angle off the axis: a straight line below the lamp

uniform Light light;

out float intensity;

void main()
{
    vec3 fragPos = light.position + vec3(tangent, 0.0, -1.0);
    intensity = clamp(spotRatio(light, fragPos), 0.0, 1.0);
}
