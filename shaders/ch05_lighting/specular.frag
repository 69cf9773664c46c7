#version 330 core
#include "lib/reflection.glsl"

in vec3 FragPos;
in vec3 Normal;

uniform vec3 objectColor;
uniform vec3 lightColor;
uniform vec3 lightPos;
uniform vec3 viewPos;
uniform float ambientStrength;
uniform float diffuseStrength;
uniform float specularStrength;
uniform float shininess;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float spec;

void main()
{
    vec3 normal = normalize(Normal);
    vec3 lightDir = normalize(lightPos - FragPos);
    vec3 viewDir = normalize(viewPos - FragPos);
    spec = phongLobe(normal, lightDir, viewDir, shininess);

    float matte = ambientStrength + diffuseStrength * diffuseFactor(normal, lightDir);
    FragColor = vec4((matte + specularStrength * spec) * lightColor * objectColor, 1.0);
}
