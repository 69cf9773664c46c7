#version 330 core
in vec2 TexCoords;

uniform sampler2D texture1;
uniform sampler2D texture2;
uniform float mixValue;   // how much of the second one

out vec4 FragColor;

void main()
{
    FragColor = mix(texture(texture1, TexCoords), texture(texture2, TexCoords), mixValue);
}
