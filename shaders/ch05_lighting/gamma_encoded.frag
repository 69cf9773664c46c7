#version 330 core
#include "lib/gamma.glsl"

in vec2 TexCoords;

uniform sampler2D image;   // an sRGB texture decodes by itself

out vec4 FragColor;   // encoded here, for a framebuffer that does not

void main()
{
    vec3 light = texture(image, TexCoords).rgb;
    FragColor = vec4(srgbEncode(light.r), srgbEncode(light.g), srgbEncode(light.b), 1.0);
}
