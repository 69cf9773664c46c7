#version 330 core
#include "lib/reflection.glsl"

#define LAMPS 3

in vec3 FragPos;
in vec3 Normal;
in vec2 TexCoords;

uniform sampler2D diffuseTexture;
uniform vec3 lampPos[LAMPS];
uniform vec3 lampColor[LAMPS];

out vec4 FragColor;

void main()
{
    vec3 light = vec3(0.01);
    for (int i = 0; i < LAMPS; ++i) {
        vec3 ray = lampPos[i] - FragPos;
        float diff = diffuseFactor(normalize(Normal), normalize(ray));
        light += lampColor[i] * diff / dot(ray, ray);
    }
    FragColor = vec4(light * texture(diffuseTexture, TexCoords).rgb, 1.0);
}
