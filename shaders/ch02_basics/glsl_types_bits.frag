#version 330 core
in vec2 field;   // column 0…32 from the left, row 0…16 from the bottom

uniform bvec4 truths;
uniform vec4 reals;
uniform ivec4 integers;
uniform uvec4 naturals;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out uint bit;

uint word(int group, int component)
{
    if (group == 0)
        return uint(truths[component]);
    if (group == 1)
        return floatBitsToUint(reals[component]);
    if (group == 2)
        return uint(integers[component]);
    return naturals[component];
}

void main()
{
    // Row by row from above, bit 31 at the left.
    int row = 15 - int(field.y);
    int position = 31 - int(field.x);
    int group = row / 4;
    bit = (word(group, row % 4) >> uint(position)) & 1u;

    vec3 hue = vec3(0.95, 0.75, 0.30);                          // bool
    if (group == 1)                                             // float: sign, exponent, fraction
        hue = position == 31 ? vec3(0.90, 0.35, 0.30)
            : position >= 23 ? vec3(0.40, 0.75, 0.45) : vec3(0.45, 0.60, 0.95);
    if (group == 2)                                             // int: a sign of its own
        hue = position == 31 ? vec3(0.90, 0.35, 0.30) : vec3(0.75, 0.55, 0.90);
    if (group == 3)                                             // uint
        hue = vec3(0.35, 0.75, 0.80);
    vec2 off = abs(fract(field) - 0.5);
    float gap = max(off.x, off.y) > 0.42 || (row % 4 == 3 && fract(field.y) < 0.16) ? 0.0 : 1.0;
    FragColor = vec4(mix(vec3(0.07, 0.08, 0.10), hue * (bit == 1u ? 1.0 : 0.24), gap), 1.0);
}
