#version 330 core
in vec2 uv;
uniform float gain;
out vec4 color;
void main() { color = vec4(gain * uv, 0.0, 1.0); }
