#version 330 core
// No includes, lamps from the first to the last, powers by multiplication in another order.
struct Light { vec3 position; vec3 color; };

in vec3 FragPos;
in vec3 Normal;

uniform vec3 camPos;
uniform vec3 albedo;
uniform float metallic;
uniform float roughness;
uniform Light lights[4];

out vec4 FragColor;
out float D;
out float G;
out vec3 F;

const float INVERSE_PI = 0.31830988618;

float shadowing(float cosine, float k)
{
    return cosine / mix(k, 1.0, cosine);
}

void main()
{
    vec3 N = normalize(Normal), V = normalize(camPos - FragPos);
    float NV = clamp(dot(V, N), 0.0, 1.0);
    vec3 F0 = 0.04 * (1.0 - metallic) + metallic * albedo;
    float a2 = roughness * roughness * roughness * roughness;
    float k = (roughness + 1.0) * (roughness + 1.0) * 0.125;

    FragColor = vec4(0.02 * albedo, 1.0);
    for (int n = 0; n < 4; n++) {
        vec3 toLamp = lights[n].position - FragPos;
        vec3 L = toLamp / length(toLamp);
        vec3 H = normalize(L + V);
        float NL = max(dot(L, N), 0.0);
        vec3 off = cross(N, H);
        float nh = dot(N, H);
        float below = a2 * nh * nh + dot(off, off);
        float d = a2 * INVERSE_PI / (below * below);
        float g = shadowing(NV, k) * shadowing(NL, k);
        float rest = 1.0 - max(dot(V, H), 0.0);
        vec3 f = F0 + (1.0 - F0) * (rest * rest * rest * rest * rest);
        vec3 mirrored = d * g * f / (4.0 * NV * NL + 0.0001);
        vec3 matte = (vec3(1.0) - f) * (1.0 - metallic) * albedo * INVERSE_PI;
        FragColor.rgb += (matte + mirrored) * lights[n].color * NL / dot(toLamp, toLamp);
        if (n == 0) {
            D = d;
            G = g;
            F = f;
        }
    }
}
