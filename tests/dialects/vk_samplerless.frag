#version 450
#extension GL_EXT_samplerless_texture_functions : require
layout (set = 0, binding = 0) uniform texture2D map;
layout (location = 0) out vec4 color;
void main() { color = texelFetch(map, ivec2(0), 0) + vec4(textureSize(map, 0), 0, 0); }
