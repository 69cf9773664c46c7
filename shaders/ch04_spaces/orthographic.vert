#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform mat4 view;
uniform float left;
uniform float right;
uniform float bottom;
uniform float top;
uniform float near;
uniform float far;

out vec3 Normal;
out vec3 Color;

void main()
{
    mat4 projection = mat4(1.0);
    projection[0][0] = 2.0 / (right - left);
    projection[1][1] = 2.0 / (top - bottom);
    projection[2][2] = -2.0 / (far - near);
    projection[3] = vec4(-(right + left) / (right - left), -(top + bottom) / (top - bottom),
                         -(far + near) / (far - near), 1.0);

    Normal = aNormal;
    Color = aColor;
    gl_Position = projection * (view * vec4(aPos, 1.0));
}
