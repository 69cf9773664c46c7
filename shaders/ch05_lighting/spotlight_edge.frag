#version 330 core
#include "lib/spotlight.glsl"

in float tangent;   // of the angle off the axis: a straight line below the lamp

uniform Spot light;

out float intensity;

void main()
{
    vec3 fragPos = light.position + vec3(tangent, 0.0, -1.0);
    intensity = spotIntensity(light, fragPos);
}
