#version 330 core
#include "lib/furnace.glsl"

in float normalView;
in float roughness;

uniform float ring[RING];

layout (location = 0) out float direct;
layout (location = 1) out float sky;
layout (location = 2) out float smith;

void main()
{
    direct = reflectedShare(DIRECT, normalView, roughness, ring);
    sky = reflectedShare(SKY, normalView, roughness, ring);
    smith = reflectedShare(SMITH, normalView, roughness, ring);
}
