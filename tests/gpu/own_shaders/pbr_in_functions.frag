#version 330 core
// One function a lamp, factors in a struct, Schlick's power by pow.
struct Light { vec3 position; vec3 color; };
struct Factors { float d; float g; vec3 f; };

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

Factors factors(vec3 n, vec3 v, vec3 l)
{
    vec3 h = normalize(v + l);
    float alpha = roughness * roughness;
    vec3 aside = cross(h, n);
    float stretched = length(vec2(alpha * dot(n, h), length(aside)));
    float k = pow(roughness + 1.0, 2.0) / 8.0;
    float nv = max(dot(n, v), 0.0), nl = max(dot(n, l), 0.0);
    vec3 base = mix(vec3(0.04), albedo, metallic);
    float fifth = pow(max(1.0 - max(dot(h, v), 0.0), 1.0e-12), 5.0);
    return Factors(pow(alpha / (stretched * stretched), 2.0) / acos(-1.0),
                   nv * nl / ((nv - nv * k + k) * (nl - nl * k + k)),
                   mix(base, vec3(1.0), fifth));
}

vec3 fromLamp(Light lamp, vec3 n, vec3 v, out Factors found)
{
    vec3 ray = lamp.position - FragPos;
    vec3 l = normalize(ray);
    found = factors(n, v, l);
    float nv = max(dot(n, v), 0.0), nl = max(dot(n, l), 0.0);
    vec3 specular = found.f * (found.d * found.g / (0.0001 + nv * nl * 4.0));
    vec3 diffuse = albedo * (1.0 - metallic) / acos(-1.0) * (1.0 - found.f);
    return nl * lamp.color / dot(ray, ray) * (specular + diffuse);
}

void main()
{
    vec3 n = normalize(Normal), v = normalize(camPos - FragPos);
    Factors first, other;
    vec3 sum = fromLamp(lights[0], n, v, first);
    for (int i = 1; i < 4; ++i)
        sum = sum + fromLamp(lights[i], n, v, other);
    D = first.d;
    G = first.g;
    F = first.f;
    FragColor = vec4(sum + 0.02 * albedo, 1.0);
}
