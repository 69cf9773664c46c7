#version 450 core
layout (binding = 0) uniform atomic_uint hits;
out vec4 color;
void main() { color = vec4(float(atomicCounterIncrement(hits))); }
