#version 330 core
uniform vec3 a;
uniform vec4 a;
out vec4 color;
void main() { color = a; }
