#version 310 es
precision highp float;
layout (location = 0) in vec2 uv;
layout (binding = 0) uniform sampler2D map;
layout (location = 0) out vec4 color;
void main() { color = texture(map, uv); }
