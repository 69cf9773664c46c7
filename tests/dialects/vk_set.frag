#version 450
layout (set = 1, binding = 0) uniform Light { vec4 color; } light;
layout (location = 0) out vec4 color;
void main() { color = light.color; }
