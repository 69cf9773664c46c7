#version 330 core
#include "lib/drawing.glsl"

in vec2 place;   // −1…1 over one panel

uniform sampler2D lit;   // what the program under test drew
uniform vec2 dials;      // where its two dials stand, 0…1: strength and the unused one
uniform vec2 turned;     // 1 for the dial that was turned

out vec4 FragColor;

vec3 dial(vec3 color, vec2 off, float value, float marked, vec3 hue)
{
    float radius = length(off);
    float angle = radians(225.0 - 270.0 * value);
    vec2 hand = vec2(cos(angle), sin(angle));
    color = mix(color, mix(vec3(0.10), hue, 0.30), 1.0 - smoothstep(0.24, 0.25, radius));
    float aside = abs(dot(off, vec2(-hand.y, hand.x)));
    float needle = dot(off, hand) > 0.0 ? 1.0 - smoothstep(0.0125, 0.0185, aside) : 0.0;
    color = mix(color, vec3(0.95), needle * step(radius, 0.22));
    float rim = abs(radius - 0.27) - mix(0.008, 0.022, marked);
    return mix(color, mix(vec3(0.35), vec3(1.0, 0.85, 0.3), marked), step(rim, 0.0));
}

void main()
{
    vec3 color = vec3(0.035, 0.045, 0.06);
    float lamp = length(place - vec2(0.0, 0.36));
    vec3 glow = texelFetch(lit, ivec2(0), 0).rgb;
    color += glow * 0.35 * exp(-5.0 * max(lamp - 0.34, 0.0));
    color = mix(color, glow, 1.0 - smoothstep(0.34, 0.35, lamp));
    color = dial(color, place - vec2(-0.42, -0.5), dials.x, turned.x, vec3(0.5, 0.8, 1.0));
    color = dial(color, place - vec2(0.42, -0.5), dials.y, turned.y, vec3(0.6));
    color *= step(max(abs(place.x), abs(place.y)), 0.97);
    FragColor = vec4(encoded(color), 1.0);
}
