#version 330 core
out vec4 color;
float f(float x) { return x > 1.0 ? f(x - 1.0) : x; }
void main() { color = vec4(f(2.0)); }
