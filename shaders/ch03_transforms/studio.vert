#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform mat4 model;
uniform mat4 view;
uniform mat4 projection;
uniform mat3 normalMatrix;   // transpose(inverse(mat3(model)))

out vec3 Normal;
out vec3 Color;

void main()
{
    Normal = normalMatrix * aNormal;
    Color = aColor;
    gl_Position = projection * (view * (model * vec4(aPos, 1.0)));
}
