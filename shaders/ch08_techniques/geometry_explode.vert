#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform mat4 model;

out VS_OUT {
    vec3 world;
    vec3 color;
} vs_out;

void main()
{
    vs_out.world = (model * vec4(aPos, 1.0)).xyz;
    vs_out.color = aColor * (0.6 + 0.4 * aNormal.y);
    gl_Position = vec4(vs_out.world, 1.0);
}
