#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform float yaw;     // around y, in radians
uniform float pitch;   // around x
uniform float roll;    // around z
uniform mat4 view;
uniform mat4 projection;

out vec3 Normal;
out vec3 Color;
out vec3 Turned;

mat3 aroundX(float angle)
{
    float c = cos(angle), s = sin(angle);
    return mat3(1.0, 0.0, 0.0, 0.0, c, s, 0.0, -s, c);   // column by column
}

mat3 aroundY(float angle)
{
    float c = cos(angle), s = sin(angle);
    return mat3(c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c);
}

mat3 aroundZ(float angle)
{
    float c = cos(angle), s = sin(angle);
    return mat3(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
}

void main()
{
    mat3 yawing = aroundY(yaw), pitching = aroundX(pitch), rolling = aroundZ(roll);

    Turned = yawing * (pitching * (rolling * aPos));
    Normal = yawing * (pitching * (rolling * aNormal));
    Color = aColor;
    gl_Position = projection * (view * vec4(Turned, 1.0));
}
