#version 330 core
#include "lib/reflection.glsl"

in vec3 FragPos;
in vec3 Normal;

uniform vec3 objectColor;
uniform vec3 lightColor;
uniform vec3 lightPos;
uniform float ambientStrength;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float diff;

void main()
{
    vec3 lightDir = normalize(lightPos - FragPos);
    diff = diffuseFactor(normalize(Normal), lightDir);
    vec3 ambient = ambientStrength * lightColor;
    FragColor = vec4((ambient + diff * lightColor) * objectColor, 1.0);
}
