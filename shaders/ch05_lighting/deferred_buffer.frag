#version 330 core
in vec3 FragPos;
in vec3 Normal;
in vec3 Color;

layout (location = 0) out vec3 gPosition;
layout (location = 1) out vec3 gNormal;
layout (location = 2) out vec4 gAlbedoSpec;

void main()
{
    gPosition = FragPos;
    gNormal = normalize(Normal);
    gAlbedoSpec = vec4(Color, 0.8 * Color.r);
}
