#version 330 core
in vec2 TexCoords;

uniform sampler2D screenTexture;
uniform float kernel[9];   // row by row, the uppermost first

out vec4 FragColor;

void main()
{
    vec2 texel = 1.0 / vec2(textureSize(screenTexture, 0));
    vec3 sum = vec3(0.0);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            vec2 offset = vec2(column - 1, 1 - row) * texel;
            sum += kernel[3 * row + column] * texture(screenTexture, TexCoords + offset).rgb;
        }
    }
    FragColor = vec4(sum, 1.0);
}
