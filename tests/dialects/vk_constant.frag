#version 450
layout (constant_id = 0) const int steps = 4;
layout (location = 0) out vec4 color;
void main() { float taps[steps]; taps[0] = 1.0; color = vec4(taps[0] * float(steps)); }
