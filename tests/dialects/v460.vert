#version 460 core
void main() { gl_Position = vec4(float(gl_BaseInstance + gl_DrawID)); }
