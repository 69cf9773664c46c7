#version 330 core
uniform vec2 pair;
uniform vec3 triple;
uniform vec4 quad;
uniform bvec2 truths2;
uniform bvec3 truths3;
uniform bvec4 truths4;

layout (location = 0) out vec2 pairOut;
layout (location = 1) out vec3 tripleOut;
layout (location = 2) out vec4 quadOut;
layout (location = 3) out ivec2 truths2Out;   // an output can't be bool
layout (location = 4) out ivec3 truths3Out;
layout (location = 5) out ivec4 truths4Out;

void main()
{
    pairOut = pair;
    tripleOut = triple;
    quadOut = quad;
    truths2Out = ivec2(truths2);
    truths3Out = ivec3(truths3);
    truths4Out = ivec4(truths4);
}
