#version 330 core
in vec2 TexCoords;
in vec2 MaskCoords;

uniform sampler2D bricks;
uniform sampler2D plaster;
uniform sampler2D mask;        // red: how much of the plaster is left

out vec4 FragColor;

void main()
{
    float weight = texture(mask, MaskCoords).r;
    FragColor = mix(texture(bricks, TexCoords), texture(plaster, TexCoords), weight);
}
