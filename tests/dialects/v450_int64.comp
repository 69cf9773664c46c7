#version 450 core
#extension GL_ARB_gpu_shader_int64 : require
layout (local_size_x = 1) in;
layout (binding = 0) buffer Data { uint64_t x; };
void main() { x += 1ul; }
