#version 330 core
#include "lib/gamma.glsl"

in float linear;   // light, from black at the left to white at the right

uniform float gamma;

layout (location = 0) out float power;     // the plain power curve
layout (location = 1) out float srgb;      // the sRGB curve
layout (location = 2) out float decoded;   // from sRGB back to light

void main()
{
    power = gammaEncode(linear, gamma);
    srgb = srgbEncode(linear);
    decoded = srgbDecode(linear);
}
