#version 330 core
#include "lib/noise.glsl"

in vec2 place;

uniform int kind;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float level;

void main()
{
    if (kind == 0)
        level = valueNoise(place);
    else if (kind == 1)
        level = gradientNoise(place);
    else if (kind == 2)
        level = octaves(place);
    else
        level = octaves(place + 1.5 * vec2(octaves(place + 5.25), octaves(place + 9.75)));
    // From deep water over foam to rock.
    float shade = clamp(0.5 + 0.62 * level, 0.0, 1.0);
    vec3 color = mix(vec3(0.02, 0.09, 0.20), vec3(0.10, 0.47, 0.55), smoothstep(0.0, 0.45, shade));
    color = mix(color, vec3(0.97, 0.92, 0.80), smoothstep(0.35, 0.65, shade));
    FragColor = vec4(mix(color, vec3(0.72, 0.30, 0.13), smoothstep(0.6, 1.0, shade)), 1.0);
}
