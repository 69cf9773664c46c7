#version 330 core
#include "lib/gamma.glsl"

in float code;   // 0 … 256, the fraction does not count

out vec4 FragColor;   // light: an sRGB framebuffer encodes it by itself

void main()
{
    FragColor = vec4(vec3(srgbDecode(floor(code) / 255.0)), 1.0);
}
