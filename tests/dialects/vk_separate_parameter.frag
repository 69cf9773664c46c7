#version 450
layout (binding = 0) uniform itexture2D map;
layout (binding = 1) uniform sampler nearest;
layout (location = 0) out ivec4 color;
ivec4 look(itexture2D t, sampler s, vec2 at) { return texture(isampler2D(t, s), at); }
void main() { color = look(map, nearest, vec2(0.5)); }
