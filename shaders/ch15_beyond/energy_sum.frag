#version 330 core
#include "lib/energy.glsl"

in vec2 place;              // of the light, seen from above: in a disc, dω (n·l) is an area

uniform float roughness;
uniform vec3 view;

layout (location = 0) out float first;      // of a metal that absorbs nothing
layout (location = 1) out float together;

void main()
{
    float upright2 = 1.0 - dot(place, place);
    vec3 normal = vec3(0.0, 0.0, 1.0);
    vec3 light = vec3(place, sqrt(max(upright2, 0.0001)));
    float inside = upright2 > 0.0001 ? 1.0 / light.z : 0.0;
    first = inside * metal(normal, view, light, roughness, vec3(1.0), 0.0).r;
    together = inside * metal(normal, view, light, roughness, vec3(1.0), 1.0).r;
}
