#version 330 core
#include "lib/lights.glsl"

#define POINT_LIGHTS 4

in vec3 FragPos;
in vec3 Normal;
in vec3 Color;

uniform vec3 viewPos;
uniform vec3 specular;
uniform float shininess;
uniform DirLight dirLight;
uniform PointLight pointLights[POINT_LIGHTS];
uniform SpotLight spotLight;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec3 directional;
layout (location = 2) out vec3 points;
layout (location = 3) out vec3 spot;

void main()
{
    vec3 viewDir = normalize(viewPos - FragPos);
    Surface surface = Surface(FragPos, normalize(Normal), viewDir, Color, specular, shininess);

    directional = CalcDirLight(dirLight, surface);
    points = vec3(0.0);
    for (int i = 0; i < POINT_LIGHTS; ++i)
        points += CalcPointLight(pointLights[i], surface);
    spot = CalcSpotLight(spotLight, surface);
    FragColor = vec4(directional + points + spot, 1.0);
}
