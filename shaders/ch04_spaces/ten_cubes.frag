#version 330 core
#include "lib/studio.glsl"

in vec3 Normal;
in vec2 TexCoords;

uniform sampler2D wood;
uniform float number;   // of the box, 1 … 10

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float box;

void main()
{
    vec3 color = texture(wood, TexCoords).rgb;
    FragColor = vec4(studio(1.3 * decoded(color), Normal), 1.0);
    box = number;
}
