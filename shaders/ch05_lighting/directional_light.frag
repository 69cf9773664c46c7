#version 330 core
#include "lib/lights.glsl"

in vec3 FragPos;
in vec3 Normal;
in vec3 Color;

uniform vec3 viewPos;
uniform vec3 specular;
uniform float shininess;
uniform DirLight light;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec3 lightDir;   // from the surface to the light: the same everywhere

void main()
{
    vec3 viewDir = normalize(viewPos - FragPos);
    Surface surface = Surface(FragPos, normalize(Normal), viewDir, Color, specular, shininess);
    lightDir = normalize(-light.direction);
    FragColor = vec4(CalcDirLight(light, surface), 1.0);
}
