#version 330 core
#include "lib/reflection.glsl"

struct Material {
    sampler2D diffuse;
    sampler2D specular;
    float shininess;
};

struct Light {
    vec3 position;
    vec3 ambient;
    vec3 diffuse;
    vec3 specular;
};

in vec3 FragPos;
in vec3 Normal;
in vec2 TexCoords;

uniform vec3 viewPos;
uniform Material material;
uniform Light light;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec3 highlight;   // the specular part alone

void main()
{
    vec3 normal = normalize(Normal);
    vec3 lightDir = normalize(light.position - FragPos);
    vec3 viewDir = normalize(viewPos - FragPos);
    float diff = diffuseFactor(normal, lightDir);
    float spec = phongLobe(normal, lightDir, viewDir, material.shininess);

    vec3 color = texture(material.diffuse, TexCoords).rgb;
    highlight = light.specular * spec * texture(material.specular, TexCoords).rgb;
    FragColor = vec4((light.ambient + light.diffuse * diff) * color + highlight, 1.0);
}
