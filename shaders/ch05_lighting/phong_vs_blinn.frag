#version 330 core
#include "lib/reflection.glsl"

in vec2 place;   // the surface lies at height 0, the lit point in the middle

uniform vec3 lightDir;        // to the lamp, of unit length
uniform float shininess;      // Phong's exponent
uniform float blinnExponent;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float phong;   // for a viewer in the direction of `place`
layout (location = 2) out float blinn;

// Whether `place` is on the ray from the middle that points this way.
bool onRay(vec2 direction)
{
    float aside = abs(place.x * direction.y - place.y * direction.x);
    return aside < 0.006 && dot(place, direction) > 0.0;
}

void main()
{
    vec3 normal = vec3(0.0, 1.0, 0.0);
    vec3 viewDir = normalize(vec3(place, 0.0));
    phong = phongLobe(normal, lightDir, viewDir, shininess);
    blinn = blinnLobe(normal, lightDir, viewDir, blinnExponent);

    // A lobe reaches as far as it is bright.
    float radius = length(place);
    vec3 color = vec3(0.012, 0.015, 0.022);
    if (radius < blinn)
        color = radius < phong ? vec3(0.85, 0.48, 0.12) : vec3(0.03, 0.17, 0.42);
    else if (radius < phong)
        color = vec3(0.75, 0.05, 0.03);
    if (onRay(lightDir.xy))
        color = vec3(0.95, 0.85, 0.45);
    if (onRay(vec2(-lightDir.x, lightDir.y)) || onRay(vec2(0.0, 1.0)))
        color = vec3(0.30, 0.32, 0.36);
    if (place.y < 0.0)
        color = vec3(0.10, 0.11, 0.12);
    FragColor = vec4(color, 1.0);
}
