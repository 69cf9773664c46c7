#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform vec3 axis;     // of any length
uniform float angle;   // in radians, counter-clockwise where the axis points at the viewer
uniform vec3 offset;
uniform mat4 view;
uniform mat4 projection;

out vec3 Normal;
out vec3 Color;
out vec3 Turned;

void main()
{
    vec3 u = normalize(axis);
    mat3 crossed = mat3(0.0, u.z, -u.y, -u.z, 0.0, u.x, u.y, -u.x, 0.0);   // column by column
    mat3 rotation = mat3(cos(angle)) + (1.0 - cos(angle)) * outerProduct(u, u)
                  + sin(angle) * crossed;

    Turned = rotation * aPos + offset;
    Normal = rotation * aNormal;
    Color = aColor;
    gl_Position = projection * (view * vec4(Turned, 1.0));
}
