#version 330 core
// In structs and functions; the display's gamma from the shipped library.
#include "lib/drawing.glsl"

struct Directions { vec3 normal, light, view; };

in vec3 FragPos;
in vec3 Normal;

uniform vec3 lightPos;
uniform vec3 viewPos;
uniform float shininess;
uniform bool blinn;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float specular;

Directions directions()
{
    return Directions(normalize(Normal), normalize(lightPos - FragPos),
                      normalize(viewPos - FragPos));
}

float phongCosine(Directions d)
{
    // The mirrored ray written out.
    vec3 mirrored = 2.0 * dot(d.normal, d.light) * d.normal - d.light;
    return dot(mirrored, d.view);
}

float blinnCosine(Directions d)
{
    vec3 halfway = 0.5 * (d.light + d.view);
    return dot(d.normal, halfway) / length(halfway);
}

void main()
{
    Directions d = directions();
    float cosine = blinn ? blinnCosine(d) : phongCosine(d);
    float gate = dot(d.light, d.normal) > 0.0 ? 1.0 : 0.0;
    specular = gate * step(0.0, cosine) * pow(max(cosine, 1.0e-30), shininess);

    float diffuse = max(0.0, dot(d.light, d.normal));
    vec3 surface = mix(vec3(0.10, 0.14, 0.20), vec3(0.55, 0.16, 0.12),
                       bvec3(FragPos.y > 0.001));
    vec3 light = 0.06 * surface + 0.9 * diffuse * surface + 0.55 * specular;
    FragColor = vec4(encoded(clamp(light, 1.0e-6, 1.0)), 1.0);
}
