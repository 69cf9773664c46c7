#version 330 core
in vec2 TexCoords;
in float lod;

uniform sampler2D image;

out vec4 FragColor;

void main()
{
    FragColor = textureLod(image, TexCoords, lod);
}
