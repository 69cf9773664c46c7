#version 330 core
#include "lib/soft_shadow.glsl"

in vec2 at;

uniform sampler2D map;
uniform sampler2D means;
uniform vec2 points[POINTS];    // in a circle of radius 1
uniform float lamp;             // its radius, as seen from the floor, in the map's coordinates

layout (location = 0) out float variance;
layout (location = 1) out float closer;

void main()
{
    variance = byVariance(means, at);
    closer = byCloser(map, at, points, lamp);
}
