#version 330 core
uniform sampler2D one;    // drawn with one sample a pixel
uniform sampler2D four;   // with four

in vec2 at;   // the left half and the right one, each from 0 to 1

layout (location = 0) out vec4 FragColor;

void main()
{
    vec2 place = vec2(fract(at.x), at.y);
    ivec2 texel = ivec2(place * vec2(textureSize(one, 0)));
    float lit = at.x < 1.0 ? texelFetch(one, texel, 0).r : texelFetch(four, texel, 0).r;
    // Light is averaged, so it is encoded for the display afterwards.
    float shown = pow(max(lit, 1.0e-6), 1.0 / 2.2);
    vec3 color = mix(vec3(0.11, 0.14, 0.22), vec3(0.96, 0.93, 0.84), shown);
    FragColor = vec4(abs(at.x - 1.0) < 0.004 ? vec3(0.95, 0.55, 0.10) : color, 1.0);
}
