#version 330 core
// Each factor as textbooks print it: every cosine kept from below zero, nothing rearranged.
struct Light { vec3 position; vec3 color; };

in vec3 FragPos;
in vec3 Normal;

uniform vec3 camPos;
uniform vec3 albedo;
uniform float metallic;
uniform float roughness;
uniform Light lights[4];

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float D;
layout (location = 2) out float G;
layout (location = 3) out vec3 F;

const float pi = 3.14159265359;

float facingShare(vec3 n, vec3 h)
{
    float a2 = roughness * roughness * roughness * roughness;
    float cosine = max(dot(n, h), 0.0);
    float below = cosine * cosine * (a2 - 1.0) + 1.0;
    return a2 / (pi * below * below);
}

float openShare(float cosine)
{
    float k = (roughness + 1.0) * (roughness + 1.0) / 8.0;
    return cosine / (cosine * (1.0 - k) + k);
}

void main()
{
    vec3 n = normalize(Normal);
    vec3 v = normalize(camPos - FragPos);
    float nv = max(dot(n, v), 0.0);
    vec3 base = mix(vec3(0.04), albedo, metallic);
    vec3 outgoing = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        vec3 ray = lights[i].position - FragPos;
        float away = length(ray);
        vec3 l = normalize(ray);
        vec3 h = normalize(v + l);
        float nl = max(dot(n, l), 0.0);
        float d = facingShare(n, h);
        float g = openShare(nv) * openShare(nl);
        vec3 f = base + (1.0 - base) * pow(clamp(1.0 - max(dot(h, v), 0.0), 0.0, 1.0), 5.0);
        vec3 specular = d * g * f / (4.0 * nv * nl + 0.0001);
        vec3 refracted = (vec3(1.0) - f) * (1.0 - metallic);
        outgoing += (refracted * albedo / pi + specular) * lights[i].color / (away * away) * nl;
        if (i == 0) {
            D = d;
            G = g;
            F = f;
        }
    }
    FragColor = vec4(0.02 * albedo + outgoing, 1.0);
}
