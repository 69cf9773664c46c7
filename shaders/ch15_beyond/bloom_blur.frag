#version 330 core
in vec2 TexCoords;

uniform sampler2D image;    // filtered linearly
uniform vec2 along;         // from texel to texel, in texture coordinates

out vec4 FragColor;

void main()
{
    // Nine weights 66, 220, 495, 792, 924 … over 4070 by five samples: one between two texels has
    // both of them, by where it lies.
    const float weights[3] = float[](0.2270270270, 0.3162162162, 0.0702702703);
    const float offsets[3] = float[](0.0, 1.3846153846, 3.2307692308);
    vec3 sum = weights[0] * texture(image, TexCoords).rgb;
    for (int k = 1; k < 3; ++k) {
        vec2 off = offsets[k] * along;
        sum += weights[k] * (texture(image, TexCoords + off).rgb + texture(image, TexCoords - off).rgb);
    }
    FragColor = vec4(sum, 1.0);
}
