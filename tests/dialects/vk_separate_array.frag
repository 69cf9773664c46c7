#version 450
layout (set = 1, binding = 2) uniform textureCube maps[4];
layout (set = 1, binding = 3) uniform samplerShadow compared;
layout (set = 1, binding = 4) uniform sampler linear;
layout (set = 1, binding = 5) uniform texture2D depths;
layout (location = 0) in vec3 direction;
layout (location = 0) out vec4 color;
void main()
{
    float lit = texture(sampler2DShadow(depths, compared), direction);
    color = lit * texture(samplerCube(maps[2], linear), direction);
}
