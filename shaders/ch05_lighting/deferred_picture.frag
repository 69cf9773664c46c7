#version 330 core
#include "lib/drawing.glsl"

in vec2 TexCoords;

uniform sampler2D gPosition;
uniform sampler2D gNormal;
uniform sampler2D gAlbedoSpec;
uniform sampler2D lit;

out vec4 FragColor;

// Upper half: places and normals as colours; lower half: albedo, and what becomes of all three.
vec3 shown(vec2 place)
{
    bool right = TexCoords.x > 0.5;
    if (TexCoords.y > 0.5)
        return right ? 0.5 + 0.5 * texture(gNormal, place).rgb
                     : 0.5 + 0.14 * texture(gPosition, place).rgb;
    return encoded(min(right ? texture(lit, place).rgb : texture(gAlbedoSpec, place).rgb, 1.0));
}

void main()
{
    vec2 place = fract(2.0 * TexCoords);
    vec2 off = 0.25 / vec2(textureSize(lit, 0));
    vec3 sum = shown(place - off) + shown(place + off)
             + shown(place + vec2(-off.x, off.y)) + shown(place + vec2(off.x, -off.y));
    FragColor = vec4(0.25 * sum, 1.0);
}
