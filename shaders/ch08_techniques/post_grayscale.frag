#version 330 core
#include "lib/drawing.glsl"

in vec2 TexCoords;

uniform sampler2D screenTexture;

out vec4 FragColor;
out float average;     // every channel alike
out float luma;        // the eye's weights, of the numbers that stand for light
out float luminance;   // the same of the light itself, encoded again

void main()
{
    vec3 color = texture(screenTexture, TexCoords).rgb;
    average = (color.r + color.g + color.b) / 3.0;
    vec3 weights = vec3(0.2126, 0.7152, 0.0722);
    luma = dot(color, weights);
    luminance = encoded(vec3(dot(decoded(color), weights))).r;
    float grey = TexCoords.x < 1.0 / 3.0 ? average : TexCoords.x < 2.0 / 3.0 ? luma : luminance;
    FragColor = vec4(vec3(grey), 1.0);
}
