#version 330 core
in vec2 TexCoords;

uniform sampler2D normalMap;

out vec3 normal;

void main()
{
    normal = 2.0 * texture(normalMap, TexCoords).rgb - 1.0;
}
