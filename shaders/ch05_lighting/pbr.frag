#version 330 core
#include "lib/microfacets.glsl"

#define LIGHTS 4

struct Light {
    vec3 position;
    vec3 color;
};

in vec3 FragPos;
in vec3 Normal;

uniform vec3 camPos;
uniform vec3 albedo;
uniform float metallic;
uniform float roughness;
uniform Light lights[LIGHTS];

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float D;   // the three factors, for the first light
layout (location = 2) out float G;
layout (location = 3) out vec3 F;

void main()
{
    vec3 normal = normalize(Normal);
    vec3 viewDir = normalize(camPos - FragPos);
    float normalView = max(dot(normal, viewDir), 0.0);
    vec3 f0 = mix(vec3(0.04), albedo, metallic);

    vec3 sum = 0.02 * albedo;
    for (int i = LIGHTS - 1; i >= 0; --i) {
        vec3 ray = lights[i].position - FragPos;
        vec3 lightDir = normalize(ray);
        vec3 halfway = normalize(viewDir + lightDir);
        float normalLight = max(dot(normal, lightDir), 0.0);

        D = distributionGGX(normal, halfway, roughness);
        G = geometrySmith(normalView, normalLight, roughness);
        F = fresnelSchlick(dot(halfway, viewDir), f0);
        vec3 specular = D * G * F / (4.0 * normalView * normalLight + 0.0001);
        vec3 diffuse = (1.0 - F) * (1.0 - metallic) * albedo / PI;

        vec3 radiance = lights[i].color / dot(ray, ray);
        sum += (diffuse + specular) * radiance * normalLight;
    }
    FragColor = vec4(sum, 1.0);
}
