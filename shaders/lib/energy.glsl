// A rough metal with all of its light: one bounce by microfacets, and a lobe for all later ones.
#include "lib/microfacets.glsl"

uniform sampler2D table;   // E, the share of one bounce, over n·v and roughness
uniform sampler2D means;   // its mean over all directions, over roughness

float maskingGGX(float cosine, float roughness)
{
    float alpha2 = roughness * roughness * roughness * roughness;
    return 2.0 * cosine / (cosine + sqrt(alpha2 + (1.0 - alpha2) * (cosine * cosine)));
}

// f · (n·l): `later` is 1 to include later bounces, and 0 to leave them out.
vec3 metal(vec3 normal, vec3 view, vec3 light, float roughness, vec3 f0, float later)
{
    vec3 halfway = normalize(view + light);
    float normalView = max(dot(normal, view), 0.01);
    float normalLight = max(dot(normal, light), 0.0);
    vec3 fresnel = fresnelSchlick(dot(halfway, view), f0);
    float masks = maskingGGX(normalView, roughness) * maskingGGX(normalLight, roughness);
    vec3 first = distributionGGX(normal, halfway, roughness) * masks / (4.0 * normalView) * fresnel;

    // What one bounce loses leaves in all directions, and in none by itself more than it lost.
    float mean = texture(means, vec2(0.5, roughness)).r;
    float lost = 1.0 - texture(table, vec2(normalView, roughness)).r;
    float lostThere = 1.0 - texture(table, vec2(normalLight, roughness)).r;
    vec3 average = (20.0 * f0 + 1.0) / 21.0;
    vec3 tint = average * average * mean / (1.0 - average * (1.0 - mean));
    return first + later * tint * (lost * lostThere / (PI * (1.0 - mean))) * normalLight;
}
