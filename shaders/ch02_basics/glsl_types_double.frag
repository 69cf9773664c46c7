#version 400 core
uniform double real;
uniform dvec2 pair;

layout (location = 0) out uvec2 realOut;   // an output can't be double: its two halves
layout (location = 1) out uvec4 pairOut;

void main()
{
    realOut = unpackDouble2x32(real);
    pairOut = uvec4(unpackDouble2x32(pair.x), unpackDouble2x32(pair.y));
}
