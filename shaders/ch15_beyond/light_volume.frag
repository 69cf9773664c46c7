#version 330 core
#include "lib/attenuation.glsl"

flat in vec3 LampPlace;
flat in vec3 LampColor;

uniform sampler2D gPosition;
uniform sampler2D gNormal;
uniform sampler2D gAlbedoSpec;
uniform float reach;
uniform Attenuation lamp;

out vec4 FragColor;         // added up; alpha counts

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec3 ray = LampPlace - texelFetch(gPosition, here, 0).xyz;
    vec3 normal = texelFetch(gNormal, here, 0).xyz;
    float away = length(ray);
    vec3 light = vec3(0.0);
    if (away < reach)
        light = LampColor * attenuationAt(lamp, away) * max(dot(normal, ray) / away, 0.0);
    FragColor = vec4(light * texelFetch(gAlbedoSpec, here, 0).rgb, 1.0);
}
