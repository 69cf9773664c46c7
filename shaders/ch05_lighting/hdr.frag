#version 330 core
#include "lib/drawing.glsl"
#include "lib/tone.glsl"

#define CLIPPED 0
#define REINHARD 1
#define EXPOSURE 2

in vec2 TexCoords;

uniform sampler2D hdrBuffer;   // twice as wide and twice as high as what is drawn here
uniform int curve;
uniform float exposure;

out vec4 FragColor;

vec3 mapped(vec2 place)
{
    vec3 light = texture(hdrBuffer, place).rgb;
    if (curve == CLIPPED)
        return min(light, 1.0);
    if (curve == REINHARD)
        return reinhard(light);
    return exposed(light, exposure);
}

void main()
{
    // First the curve, then the mean of the four texels that meet in a pixel's middle.
    vec2 off = 0.5 / vec2(textureSize(hdrBuffer, 0));
    vec3 sum = mapped(TexCoords - off) + mapped(TexCoords + off)
             + mapped(TexCoords + vec2(-off.x, off.y)) + mapped(TexCoords + vec2(off.x, -off.y));
    FragColor = vec4(encoded(0.25 * sum), 1.0);
}
