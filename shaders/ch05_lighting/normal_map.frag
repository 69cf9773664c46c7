#version 330 core
#include "lib/reflection.glsl"

in vec3 FragPos;
in vec2 TexCoords;
in mat3 TBN;

uniform sampler2D diffuseMap;
uniform sampler2D normalMap;
uniform bool flatWall;    // as if there were no normal map
uniform vec3 lightPos;
uniform vec3 viewPos;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec3 normal;

void main()
{
    normal = 2.0 * texture(normalMap, TexCoords).rgb - 1.0;
    if (flatWall)
        normal = vec3(0.0, 0.0, 1.0);
    normal = normalize(TBN * normal);

    vec3 lightDir = normalize(lightPos - FragPos);
    vec3 viewDir = normalize(viewPos - FragPos);
    float diffuse = diffuseFactor(normal, lightDir);
    float specular = blinnLobe(normal, lightDir, viewDir, 24.0);
    vec3 color = texture(diffuseMap, TexCoords).rgb;
    FragColor = vec4(color * (0.05 + 1.15 * diffuse) + vec3(0.28) * specular, 1.0);
}
