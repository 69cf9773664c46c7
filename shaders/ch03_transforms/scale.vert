#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform vec3 factors;
uniform vec3 offset;
uniform mat4 view;
uniform mat4 projection;

out vec3 Normal;
out vec3 Color;
out vec4 Scaled;

void main()
{
    mat4 matrix = mat4(1.0);
    matrix[0][0] = factors.x;
    matrix[1][1] = factors.y;
    matrix[2][2] = factors.z;
    matrix[3] = vec4(offset, 1.0);

    Scaled = matrix * vec4(aPos, 1.0);
    Normal = aNormal / factors;   // what is stretched turns its face away
    Color = aColor;
    gl_Position = projection * (view * Scaled);
}
