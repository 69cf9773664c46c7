#version 450
layout (local_size_x_id = 0, local_size_y_id = 1) in;
layout (std430, binding = 0) buffer Data { uint data[]; };
void main() { data[gl_GlobalInvocationID.x] *= gl_WorkGroupSize.x; }
