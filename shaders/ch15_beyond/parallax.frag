#version 330 core
#include "lib/drawing.glsl"
#include "lib/filtered.glsl"

#define LAYERS 32

in vec2 place;              // on the wall, which is the window

uniform sampler2D depths;   // how far below the wall's plane, 0 … 1; repeated, filtered here
uniform vec3 eye;           // before the wall
uniform vec3 lamp;
uniform float scale;        // what a depth of 1 is

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec2 shifted;   // where the ray meets the stones

float depthAt(vec2 at)
{
    return filtered(depths, at).r;
}

// Down in equal layers until the ray is below the stones, then where a line between the last two
// places meets them. The loop is counted: it ends, whatever the texture says.
vec2 met(vec2 at, vec3 toEye)
{
    vec2 along = toEye.xy / toEye.z * scale / float(LAYERS);
    float depth = 0.0;
    float below = depthAt(at);
    float last = below;
    for (int i = 0; i < LAYERS && below > 0.0; ++i) {
        last = below;
        at -= along;
        depth += 1.0 / float(LAYERS);
        below = depthAt(at) - depth;
    }
    return below < last ? at + along * (below / (below - last)) : at;
}

// How much of the lamp is seen over the stones, from a place on them.
float unshaded(vec2 at, vec3 toLamp)
{
    float depth = depthAt(at);
    vec2 along = toLamp.xy / toLamp.z * scale;
    float above = 0.0;
    for (int i = 1; i <= 16; ++i) {
        float up = depth * float(i) / 16.0;
        above = max(above, depth - up - depthAt(at + along * up));
    }
    return 1.0 - clamp(8.0 * above, 0.0, 1.0);
}

void main()
{
    shifted = met(place, eye - vec3(place, 0.0));
    vec2 off = vec2(0.004, 0.0);
    vec2 slope = vec2(depthAt(shifted + off) - depthAt(shifted - off),
                      depthAt(shifted + off.yx) - depthAt(shifted - off.yx)) / 0.008;
    vec3 normal = normalize(vec3(0.10 * slope, 1.0));
    vec3 toLamp = normalize(lamp - vec3(place, 0.0));
    float depth = depthAt(shifted);
    float light = max(dot(normal, toLamp), 0.0) * unshaded(shifted, toLamp);
    vec3 stone = mix(vec3(0.62, 0.50, 0.40), vec3(0.16, 0.13, 0.12), smoothstep(0.1, 0.9, depth));
    FragColor = vec4(encoded(min(stone * (0.12 + 1.5 * light * vec3(1.0, 0.86, 0.66)), 1.0)), 1.0);
}
