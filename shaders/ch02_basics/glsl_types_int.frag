#version 330 core
uniform ivec2 pair;
uniform ivec3 triple;
uniform ivec4 quad;
uniform uvec2 natural2;
uniform uvec3 natural3;
uniform uvec4 natural4;

layout (location = 0) out ivec2 pairOut;
layout (location = 1) out ivec3 tripleOut;
layout (location = 2) out ivec4 quadOut;
layout (location = 3) out uvec2 natural2Out;
layout (location = 4) out uvec3 natural3Out;
layout (location = 5) out uvec4 natural4Out;

void main()
{
    pairOut = pair;
    tripleOut = triple;
    quadOut = quad;
    natural2Out = natural2;
    natural3Out = natural3;
    natural4Out = natural4;
}
