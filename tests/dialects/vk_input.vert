#version 450
#extension GL_KHR_vulkan_glsl : enable
layout (location = 0) in vec3 position;
layout (set = 0, binding = 0, std140) uniform View { mat4 mvp; };
void main() { gl_Position = mvp * vec4(position, 1.0); }
