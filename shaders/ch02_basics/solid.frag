#version 330 core
in vec3 TexCoords;   // s, t and r

uniform sampler3D solid;

out vec4 FragColor;

void main()
{
    FragColor = texture(solid, TexCoords);
}
