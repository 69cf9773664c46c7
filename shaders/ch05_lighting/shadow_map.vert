#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform mat4 model;
uniform mat4 view;
uniform mat4 projection;
uniform mat3 normalMatrix;   // transpose(inverse(mat3(model)))
uniform mat4 lightSpaceMatrix;

out vec3 FragPos;
out vec3 Normal;
out vec3 Color;
out vec4 FragPosLightSpace;

void main()
{
    vec4 world = model * vec4(aPos, 1.0);
    FragPos = world.xyz;
    Normal = normalMatrix * aNormal;
    Color = aColor;
    FragPosLightSpace = lightSpaceMatrix * world;
    gl_Position = projection * (view * world);
}
