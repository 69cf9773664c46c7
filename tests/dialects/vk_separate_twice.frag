#version 450
layout (binding = 0) uniform texture2D map;
uniform vec3 a;
uniform vec4 a;
out vec4 color;
void main() { color = a; }
