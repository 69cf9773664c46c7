#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;

uniform mat4 model;
uniform mat4 view;
uniform mat4 projection;
uniform int path;   // 0: the normal as it is, 1: as a point goes, 2: as a normal has to go

out vec3 FragPos;
out vec3 Normal;

void main()
{
    FragPos = vec3(model * vec4(aPos, 1.0));
    if (path == 0)
        Normal = aNormal;
    else if (path == 1)
        Normal = mat3(model) * aNormal;
    else
        Normal = transpose(inverse(mat3(model))) * aNormal;
    gl_Position = projection * (view * vec4(FragPos, 1.0));
}
