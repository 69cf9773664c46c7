#version 330 core
#include "lib/shadow.glsl"
#include "lib/reflection.glsl"

in vec3 FragPos;
in vec3 Normal;
in vec3 Color;
in vec4 FragPosLightSpace;

uniform sampler2D shadowMap;
uniform vec3 lightPos;     // a sun in this direction, so far away that its rays are parallel
uniform vec3 viewPos;
uniform float leastBias;
uniform float mostBias;
uniform int radius;        // of the texels around that are asked as well

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float shadow;
layout (location = 2) out vec3 place;     // for those who know where shadows really are
layout (location = 3) out vec3 upright;

void main()
{
    vec3 normal = normalize(Normal);
    vec3 lightDir = normalize(lightPos);
    vec3 viewDir = normalize(viewPos - FragPos);

    float bias = slopeBias(normal, lightDir, leastBias, mostBias);
    shadow = ShadowCalculation(shadowMap, shadowCoordinates(FragPosLightSpace), bias, radius);
    place = FragPos;
    upright = normal;

    // The ambient light comes from everywhere: no shadow takes it away.
    float ambient = 0.15;
    float diffuse = diffuseFactor(normal, lightDir);
    float specular = 0.2 * blinnLobe(normal, lightDir, viewDir, 32.0);
    FragColor = vec4((ambient + (1.0 - shadow) * (diffuse + specular)) * Color, 1.0);
}
