#version 330 core
#include "lib/attenuation.glsl"

in float distance;   // from the light, left to right
in float fraction;   // of the light, bottom to top

uniform Attenuation light;

layout (location = 0) out float factor;   // light left at `distance`
layout (location = 1) out float reach;    // distance at which `fraction` is left

void main()
{
    factor = attenuationAt(light, distance);
    reach = reachOf(light, fraction);
}
