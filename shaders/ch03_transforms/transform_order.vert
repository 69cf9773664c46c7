#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform mat4 first;    // the one that acts first stands nearest to the vector
uniform mat4 second;
uniform mat4 third;
uniform mat3 normalMatrix;
uniform mat4 view;
uniform mat4 projection;

out vec3 Normal;
out vec3 Color;
out vec4 Placed;

void main()
{
    Placed = third * (second * (first * vec4(aPos, 1.0)));
    Normal = normalMatrix * aNormal;
    Color = aColor;
    gl_Position = projection * (view * Placed);
}
