#version 450 core
uniform sampler2DRect map;
out vec4 color;
void main() { color = texture(map, vec2(1.0)); }
