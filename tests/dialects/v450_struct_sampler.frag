#version 450 core
struct Material { sampler2D map; float gain; };
uniform Material material;
out vec4 color;
void main() { color = texture(material.map, vec2(0.0)) * material.gain; }
