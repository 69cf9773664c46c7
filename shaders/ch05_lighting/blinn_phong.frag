#version 330 core
#include "lib/reflection.glsl"
#include "lib/drawing.glsl"

in vec3 FragPos;
in vec3 Normal;

uniform vec3 lightPos;
uniform vec3 viewPos;
uniform float shininess;
uniform bool blinn;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float specular;

void main()
{
    vec3 normal = normalize(Normal);
    vec3 lightDir = normalize(lightPos - FragPos);
    vec3 viewDir = normalize(viewPos - FragPos);

    if (blinn)
        specular = blinnLobe(normal, lightDir, viewDir, shininess);
    else
        specular = phongLobe(normal, lightDir, viewDir, shininess);

    float diffuse = diffuseFactor(normal, lightDir);
    vec3 surface = FragPos.y > 0.001 ? vec3(0.55, 0.16, 0.12) : vec3(0.10, 0.14, 0.20);
    vec3 light = surface * (0.06 + 0.9 * diffuse) + vec3(0.55) * specular;
    FragColor = vec4(encoded(min(light, 1.0)), 1.0);
}
