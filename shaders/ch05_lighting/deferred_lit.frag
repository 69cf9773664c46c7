#version 330 core
#include "lib/lamps.glsl"

in vec2 TexCoords;

uniform sampler2D gPosition;
uniform sampler2D gNormal;
uniform sampler2D gAlbedoSpec;
uniform Lamp lamps[LAMPS];
uniform vec3 viewPos;

out vec4 FragColor;

void main()
{
    vec3 place = texture(gPosition, TexCoords).rgb;
    vec3 normal = texture(gNormal, TexCoords).rgb;
    vec4 surface = texture(gAlbedoSpec, TexCoords);

    vec3 light = 0.03 * surface.rgb;
    for (int i = 0; i < LAMPS; ++i)
        light += fromLamp(lamps[i], place, normal, surface.rgb, surface.a, viewPos);
    FragColor = vec4(light, 1.0);
}
