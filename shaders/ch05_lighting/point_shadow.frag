#version 330 core
#include "lib/shadow.glsl"

in vec3 FragPos;
in vec3 Normal;
in vec3 Color;

uniform samplerCube shadowMap;   // distances from the lamp, in parts of farPlane
uniform vec3 lightPos;
uniform float farPlane;
uniform float leastBias;         // in parts of the distance
uniform float mostBias;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float shadow;
layout (location = 2) out vec3 place;
layout (location = 3) out vec3 upright;

void main()
{
    vec3 normal = normalize(Normal);
    vec3 ray = FragPos - lightPos;
    vec3 lightDir = normalize(-ray);

    // No matrix: the direction from the lamp finds the texel on the cube's six faces.
    float current = length(ray) / farPlane;
    float bias = current * slopeBias(normal, lightDir, leastBias, mostBias);
    shadow = shadowOf(current, texture(shadowMap, ray).r, bias);
    place = FragPos;
    upright = normal;

    float diffuse = max(dot(normal, lightDir), 0.0) * 4.5 / (1.0 + dot(ray, ray));
    FragColor = vec4(Color * (vec3(0.07, 0.08, 0.11)
                              + (1.0 - shadow) * diffuse * vec3(1.0, 0.84, 0.62)), 1.0);
}
