#version 330 core
#include "lib/microfacets.glsl"

#define LIGHTS 3

struct Light {
    vec3 position;
    vec3 color;
};

in vec3 FragPos;
in vec3 Normal;
in vec2 TexCoords;

uniform sampler2D colorMap;      // sRGB, which sampling decodes
uniform sampler2D surfaceMap;    // numbers: roughness in green, metalness in blue
uniform vec3 color;              // each is a factor of its map
uniform float roughness;
uniform float metallic;
uniform vec3 camPos;
uniform Light lights[LIGHTS];

out vec4 FragColor;

void main()
{
    vec3 albedo = color * texture(colorMap, TexCoords).rgb;
    vec2 surface = vec2(roughness, metallic) * texture(surfaceMap, TexCoords).gb;
    // At 0 a mirror that faces halfway would be 0 / 0.
    float rough = max(surface.x, 0.045);
    vec3 f0 = mix(vec3(0.04), albedo, surface.y);
    vec3 normal = normalize(Normal);
    vec3 view = normalize(camPos - FragPos);
    float normalView = max(dot(normal, view), 0.0);
    vec3 sum = 0.12 * albedo;
    for (int i = 0; i < LIGHTS; ++i) {
        vec3 ray = lights[i].position - FragPos;
        vec3 light = normalize(ray);
        vec3 halfway = normalize(view + light);
        float normalLight = max(dot(normal, light), 0.0);
        vec3 fresnel = fresnelSchlick(dot(halfway, view), f0);
        vec3 specular = distributionGGX(normal, halfway, rough) * fresnel
            * geometrySmith(normalView, normalLight, rough) / (4.0 * normalView * normalLight + 0.0001);
        vec3 diffuse = (1.0 - fresnel) * (1.0 - surface.y) * albedo / PI;
        sum += (diffuse + specular) * normalLight * lights[i].color / dot(ray, ray);
    }
    FragColor = vec4(sum, 1.0);
}
