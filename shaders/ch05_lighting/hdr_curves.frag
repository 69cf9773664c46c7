#version 330 core
#include "lib/tone.glsl"

in float light;

uniform float exposure;

layout (location = 0) out float byReinhard;
layout (location = 1) out float byExposure;
layout (location = 2) out float clipped;

void main()
{
    byReinhard = reinhard(vec3(light)).r;
    byExposure = exposed(vec3(light), exposure).r;
    clipped = min(light, 1.0);
}
