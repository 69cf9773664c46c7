#version 450
#extension GL_EXT_scalar_block_layout : require
layout (local_size_x = 1) in;
layout (scalar, set = 0, binding = 0) buffer Data { vec3 a; float b; };
void main() { b = a.x; }
