#version 450
layout (local_size_x = 8, local_size_x_id = 3) in;
layout (constant_id = 1) const uint step = 2u;
layout (set = 0, binding = 0) buffer Data { uint data[]; };
void main() { data[gl_GlobalInvocationID.x] += step; }
