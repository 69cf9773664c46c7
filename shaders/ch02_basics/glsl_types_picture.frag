#version 330 core
in vec2 field;   // column 0…32 from the left, row 0…16 from the bottom

uniform usampler2D bits;   // a texel a field

out vec4 FragColor;

void main()
{
    uint bit = texelFetch(bits, ivec2(field), 0).r;
    int position = 31 - int(field.x);
    int group = 3 - int(field.y) / 4;

    vec3 hue = vec3(0.95, 0.75, 0.30);                          // bool
    if (group == 1)                                             // float: sign, exponent, fraction
        hue = position == 31 ? vec3(0.90, 0.35, 0.30)
            : position >= 23 ? vec3(0.40, 0.75, 0.45) : vec3(0.45, 0.60, 0.95);
    if (group == 2)                                             // int: a sign of its own
        hue = position == 31 ? vec3(0.90, 0.35, 0.30) : vec3(0.75, 0.55, 0.90);
    if (group == 3)                                             // uint
        hue = vec3(0.35, 0.75, 0.80);
    // Gaps between fields, and wider ones below each group.
    vec2 off = abs(fract(field) - 0.5);
    bool last = int(field.y) % 4 == 0;
    float gap = max(off.x, off.y) > 0.42 || (last && fract(field.y) < 0.16) ? 0.0 : 1.0;
    FragColor = vec4(mix(vec3(0.07, 0.08, 0.10), hue * (bit == 1u ? 1.0 : 0.24), gap), 1.0);
}
