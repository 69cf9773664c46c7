#version 330 core
// Colours one channel at a time, over arrays that an earlier loop has filled; D and G from the
// shipped library.
#include "lib/microfacets.glsl"

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

void main()
{
    vec3 n = normalize(Normal);
    vec3 v = normalize(camPos - FragPos);
    float nv = max(dot(n, v), 0.0);
    float nl[4], lobe[4], weight[4];
    for (int i = 0; i < 4; ++i) {
        vec3 ray = lights[i].position - FragPos;
        vec3 l = normalize(ray);
        vec3 h = normalize(l + v);
        nl[i] = max(dot(n, l), 0.0) / dot(ray, ray);
        float cosine = max(dot(n, l), 0.0);
        float d = distributionGGX(n, h, roughness);
        float g = geometrySmith(nv, cosine, roughness);
        lobe[i] = d * g / (4.0 * nv * cosine + 0.0001);
        float c = 1.0 - max(dot(h, v), 0.0), cc = c * c;
        weight[i] = cc * cc * c;
        if (i == 0) {
            D = d;
            G = g;
        }
    }
    for (int channel = 2; channel >= 0; --channel) {
        float f0 = (1.0 - metallic) * 0.04 + metallic * albedo[channel];
        float sum = 0.02 * albedo[channel];
        for (int i = 0; i < 4; ++i) {
            float f = f0 + (1.0 - f0) * weight[i];
            float matte = (1.0 - f) * (1.0 - metallic) * albedo[channel] / PI;
            sum += (matte + lobe[i] * f) * lights[i].color[channel] * nl[i];
            if (i == 0)
                F[channel] = f;
        }
        FragColor[channel] = sum;
    }
    FragColor.a = 1.0;
}
