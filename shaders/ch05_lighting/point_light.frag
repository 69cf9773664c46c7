#version 330 core
#include "lib/lights.glsl"

in vec3 FragPos;
in vec3 Normal;
in vec3 Color;

uniform vec3 viewPos;
uniform vec3 specular;
uniform float shininess;
uniform PointLight light;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float factor;

void main()
{
    vec3 viewDir = normalize(viewPos - FragPos);
    Surface surface = Surface(FragPos, normalize(Normal), viewDir, Color, specular, shininess);
    Attenuation fading = Attenuation(light.constant, light.linear, light.quadratic);
    factor = attenuationAt(fading, length(light.position - FragPos));
    FragColor = vec4(CalcPointLight(light, surface), 1.0);
}
