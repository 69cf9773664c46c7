#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 2) in vec2 aTexCoords;

uniform mat4 model;
uniform mat4 view;
uniform mat4 projection;

out vec2 TexCoords;
out vec3 Ndc;   // where the vertex lands after the division by w

void main()
{
    TexCoords = aTexCoords;
    gl_Position = projection * (view * (model * vec4(aPos, 1.0)));
    Ndc = gl_Position.xyz / gl_Position.w;
}
