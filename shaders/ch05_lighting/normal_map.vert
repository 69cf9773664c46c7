#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 2) in vec2 aTexCoords;

uniform mat4 model;
uniform mat3 normalMatrix;   // transpose(inverse(mat3(model)))

out vec3 place;
out vec3 upright;
out vec2 uv;

void main()
{
    vec4 world = model * vec4(aPos, 1.0);
    place = world.xyz;
    upright = normalMatrix * aNormal;
    uv = aTexCoords;
    gl_Position = world;
}
