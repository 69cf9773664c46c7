#version 450
layout (binding = 0) uniform texture2D map;
layout (binding = 1) uniform sampler linear;
uniform float gain;
out vec4 color;
void main() { color = gain * texture(sampler2D(map, linear), vec2(0.5)); }
