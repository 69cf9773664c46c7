#version 400 core
#include "lib/studio.glsl"

in vec3 Corner;
flat in vec3 Facet;

uniform vec3 paint;

out vec4 FragColor;

void main()
{
    // A mosaic: each triangle in one shade; the edges of patches dark.
    float edge = min(min(Corner.x, Corner.y), Corner.z);
    float tone = 0.55 + 0.45 * fract(dot(Facet, vec3(7.3, 4.1, 5.9)));
    FragColor = vec4(studio(paint * tone * mix(0.25, 1.0, smoothstep(0.0, 0.03, edge)), Facet), 1.0);
}
