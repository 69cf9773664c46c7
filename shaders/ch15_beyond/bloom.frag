#version 330 core
#include "lib/drawing.glsl"

in vec2 TexCoords;

uniform sampler2D scene;
uniform sampler2D glow;
uniform float strength;

out vec4 FragColor;

void main()
{
    vec3 light = texture(scene, TexCoords).rgb + strength * texture(glow, TexCoords).rgb;
    FragColor = vec4(encoded(1.0 - exp(-light)), 1.0);
}
