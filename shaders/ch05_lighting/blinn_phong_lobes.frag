#version 330 core
#include "lib/reflection.glsl"

in float slope;   // tangent of the viewer's angle from the normal, negative on the mirrored side

uniform vec3 lightDir;
uniform float shininess;

layout (location = 0) out float phong;
layout (location = 1) out float blinn;

void main()
{
    vec3 normal = vec3(0.0, 1.0, 0.0);
    vec3 viewDir = normalize(vec3(slope, 1.0, 0.0));
    phong = phongLobe(normal, normalize(lightDir), viewDir, shininess);
    blinn = blinnLobe(normal, normalize(lightDir), viewDir, shininess);
}
