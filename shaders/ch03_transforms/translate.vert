#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform vec3 offset;
uniform float w;   // 1 for places, 0 for directions
uniform mat4 view;
uniform mat4 projection;

out vec3 Normal;
out vec3 Color;
out vec4 Moved;

void main()
{
    mat4 translation = mat4(1.0);
    translation[3] = vec4(offset, 1.0);   // the last column

    Moved = translation * vec4(aPos, w);
    Normal = (translation * vec4(aNormal, 0.0)).xyz;
    Color = aColor;
    gl_Position = projection * (view * vec4(Moved.xyz, 1.0));
}
