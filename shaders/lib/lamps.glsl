// Many small lamps on a surface: the same whether the surface is being drawn or read from a buffer.
#include "lib/attenuation.glsl"
#include "lib/reflection.glsl"

#define LAMPS 16

struct Lamp {
    vec3 position;
    vec3 color;
};

// What one lamp adds: diffuse and specular, fading with distance. The normal is of unit length.
vec3 fromLamp(Lamp lamp, vec3 place, vec3 normal, vec3 albedo, float gloss, vec3 viewPos)
{
    vec3 ray = lamp.position - place;
    vec3 lightDir = normalize(ray);
    vec3 viewDir = normalize(viewPos - place);
    float diffuse = diffuseFactor(normal, lightDir);
    float specular = blinnLobe(normal, lightDir, viewDir, 32.0) * gloss;
    float fading = attenuationAt(Attenuation(1.0, 1.4, 3.6), length(ray));
    return fading * lamp.color * (albedo * diffuse + vec3(specular));
}
