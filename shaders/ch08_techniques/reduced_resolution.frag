#version 330 core
in vec2 TexCoords;

uniform sampler2D whole;
uniform sampler2D halved;
uniform sampler2D halvedSmooth;
uniform sampler2D quartered;
uniform sampler2D quarteredSmooth;

out vec4 FragColor;

void main()
{
    // The same strip five times, from the left: whole, half and half smooth, quarter and smooth.
    float place = 5.0 * TexCoords.x;
    vec2 st = vec2(0.43 + 0.2 * fract(place), TexCoords.y);
    vec3 half_ = place < 2.0 ? texture(halved, st).rgb : texture(halvedSmooth, st).rgb;
    vec3 quarter = place < 4.0 ? texture(quartered, st).rgb : texture(quarteredSmooth, st).rgb;
    vec3 color = place < 1.0 ? texture(whole, st).rgb : place < 3.0 ? half_ : quarter;
    FragColor = vec4(color, 1.0);
}
