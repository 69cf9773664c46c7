#version 330 core
#include "lib/drawing.glsl"

uniform sampler2D scene;   // twice as wide and twice as high as what is drawn here

out vec4 FragColor;

// The light of one of a pixel's four texels, read at its centre.
vec3 light(vec2 off)
{
    return decoded(texture(scene, (2.0 * gl_FragCoord.xy + off) / vec2(textureSize(scene, 0))).rgb);
}

void main()
{
    // The mean of light, not of the numbers that stand for it, makes edges smooth.
    vec3 sum = light(vec2(-0.5, -0.5)) + light(vec2(0.5, -0.5))
             + light(vec2(-0.5, 0.5)) + light(vec2(0.5, 0.5));
    FragColor = vec4(encoded(0.25 * sum), 1.0);
}
