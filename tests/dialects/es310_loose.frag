#version 310 es
precision highp float;
uniform float gain;
out vec4 color;
void main() { color = vec4(gain); }
