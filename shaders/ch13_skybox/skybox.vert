#version 330 core
layout (location = 0) in vec3 aPos;

uniform mat4 view;
uniform mat4 projection;

out vec3 TexCoords;

void main()
{
    TexCoords = aPos;
    mat4 turned = mat4(mat3(view));    // the camera's turn without its place
    gl_Position = (projection * turned * vec4(aPos, 1.0)).xyww;
}
