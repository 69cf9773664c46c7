#version 330 core
// The halfway vector is never made: its cosine follows from dot products alone. Powers by exp2.
in vec3 FragPos;
in vec3 Normal;

uniform vec3 lightPos;
uniform vec3 viewPos;
uniform float shininess;
uniform bool blinn;

layout (location = 1) out float specular;
layout (location = 0) out vec4 FragColor;

vec3 unit(vec3 v)
{
    return v * inversesqrt(dot(v, v));
}

float power(float base, float exponent)
{
    return base > 0.0 ? exp2(exponent * log2(base)) : 0.0;
}

void main()
{
    vec3 n = unit(Normal), l = unit(lightPos - FragPos), v = unit(viewPos - FragPos);
    float nl = dot(n, l), nv = dot(n, v);
    vec3 between = l + v;
    float cosine = blinn ? (nl + nv) * inversesqrt(dot(between, between))
                         : 2.0 * nl * nv - dot(l, v);
    specular = nl > 0.0 ? power(cosine, shininess) : 0.0;

    vec3 surface = FragPos.y > 0.001 ? vec3(0.55, 0.16, 0.12) : vec3(0.10, 0.14, 0.20);
    vec3 light = surface * (0.06 + 0.9 * max(nl, 0.0)) + 0.55 * specular;
    for (int channel = 0; channel < 3; ++channel)
        FragColor[channel] = power(min(max(light[channel], 1.0e-6), 1.0), 1.0 / 2.2);
    FragColor.a = 1.0;
}
