#version 330 core
#include "lib/reflection.glsl"

struct Light {
    vec3 position;
    vec3 direction;
    float cutOff;   // cosine of the cone's half angle
    vec3 ambient;
    vec3 diffuse;
    vec3 specular;
};

in vec3 FragPos;
in vec3 Normal;
in vec3 Color;

uniform vec3 viewPos;
uniform vec3 specular;
uniform float shininess;
uniform Light light;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float theta;   // cosine of the angle between the ray and the axis

void main()
{
    vec3 lightDir = normalize(light.position - FragPos);
    theta = dot(lightDir, normalize(-light.direction));

    vec3 color = light.ambient * Color;
    // A larger cosine is a smaller angle: inside.
    if (theta > light.cutOff) {
        vec3 normal = normalize(Normal);
        vec3 viewDir = normalize(viewPos - FragPos);
        float diff = diffuseFactor(normal, lightDir);
        float spec = phongLobe(normal, lightDir, viewDir, shininess);
        color += light.diffuse * (diff * Color) + light.specular * (spec * specular);
    }
    FragColor = vec4(color, 1.0);
}
