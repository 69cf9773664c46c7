#version 330 core
#include "lib/microfacets.glsl"

in float t;           // the sine of the angle to the halfway vector is t³
in float roughness;

layout (location = 0) out float facing;

void main()
{
    // Crowded where a smooth surface has its peak: D (n·h) dω = 6 π t⁵ D dt, the whole ring at once.
    float sine = t * t * t;
    vec3 halfway = vec3(sine, 0.0, sqrt(1.0 - sine * sine));
    float d = distributionGGX(vec3(0.0, 0.0, 1.0), halfway, roughness);
    facing = 6.0 * PI * (t * t * t * t * t) * d;
}
