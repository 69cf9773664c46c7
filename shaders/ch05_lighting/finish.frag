#version 330 core
#include "lib/drawing.glsl"

in vec2 TexCoords;

uniform sampler2D scene;   // light, in an image twice as wide and twice as high as the picture

out vec4 FragColor;

// What a display can show of the light that one texel holds.
vec3 shown(vec2 place)
{
    return min(texture(scene, place).rgb, 1.0);
}

void main()
{
    // Four texels meet in the middle of a pixel: their mean has smooth edges.
    vec2 off = 0.5 / vec2(textureSize(scene, 0));
    vec3 sum = shown(TexCoords - off) + shown(TexCoords + off)
             + shown(TexCoords + vec2(-off.x, off.y)) + shown(TexCoords + vec2(off.x, -off.y));
    FragColor = vec4(encoded(0.25 * sum), 1.0);
}
