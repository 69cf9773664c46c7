#version 330 core
#include "lib/drawing.glsl"

in vec2 field;   // 0…16 across and 0…12 up: one square a pixel of the window

uniform sampler2D window;   // what each pixel says of its own place

out vec4 FragColor;

void main()
{
    vec2 place = texelFetch(window, ivec2(field), 0).xy;
    vec2 share = place / vec2(16.0, 12.0);
    vec3 color = vec3(0.04 + 0.55 * share.x, 0.06 + 0.45 * share.y, 0.16 + 0.16 * (1.0 - share.x));
    vec2 off = fract(field) - 0.5;
    bool first = place == vec2(0.5);
    if (first)
        color = vec3(1.0, 0.75, 0.12);
    float dot_ = 1.0 - smoothstep(0.07, 0.10, length(off));
    color = mix(color, first ? vec3(0.05) : vec3(0.75), dot_);
    color *= step(max(abs(off.x), abs(off.y)), 0.475);
    FragColor = vec4(encoded(color), 1.0);
}
