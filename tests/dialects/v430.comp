#version 430 core
layout (local_size_x = 64) in;
layout (std430, binding = 0) buffer Data { float data[]; };
shared float sums[64];
void main()
{
    sums[gl_LocalInvocationIndex] = data[gl_GlobalInvocationID.x];
    barrier();
    data[gl_GlobalInvocationID.x] = sums[0];
}
