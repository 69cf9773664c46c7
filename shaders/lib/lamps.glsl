// Many small lamps on a surface: the same whether the surface is being drawn or read from a buffer.
#include "lib/specular.glsl"

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
    float diffuse = max(dot(normal, lightDir), 0.0);
    float specular = blinnLobe(normal, lightDir, viewDir, 32.0) * gloss;
    float left = 1.0 / (1.0 + 1.4 * length(ray) + 3.6 * dot(ray, ray));
    return left * lamp.color * (albedo * diffuse + vec3(specular));
}
