#version 330 core
in vec2 field;   // column 0…32 from the left, row 0…16 from the bottom

uniform bvec4 truths;
uniform vec4 reals;
uniform ivec4 integers;
uniform uvec4 naturals;

out uint bit;

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
    bit = (word(row / 4, row % 4) >> uint(position)) & 1u;
}
