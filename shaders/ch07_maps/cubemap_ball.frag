#version 330 core
in vec3 FragPos;
in vec3 Normal;

uniform samplerCube faces;
uniform vec3 light;            // towards it

out vec4 FragColor;

void main()
{
    vec3 normal = normalize(Normal);
    float shade = 0.45 + 0.55 * max(dot(normal, light), 0.0);
    FragColor = vec4(shade * textureLod(faces, FragPos, 0.0).rgb, 1.0);
}
