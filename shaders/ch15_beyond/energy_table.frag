#version 330 core
#include "lib/furnace.glsl"

in float normalView;
in float roughness;

uniform float ring[RING];

out float share;   // of a white furnace's light that comes back after one bounce

void main()
{
    share = reflectedShare(SMITH, normalView, roughness, ring);
}
