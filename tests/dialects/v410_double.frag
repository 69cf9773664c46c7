#version 410 core
uniform double x;
out vec4 color;
void main() { color = vec4(float(x * x)); }
