#version 420 core
layout (binding = 0, rgba8) uniform image2D picture;
out vec4 color;
void main() { color = imageLoad(picture, ivec2(0)); }
