#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 3) in vec3 aColor;

uniform mat4 model;
uniform mat4 view;
uniform mat4 projection;

out vec3 Color;
out float Distance;   // along the view direction

void main()
{
    vec4 seen = view * (model * vec4(aPos, 1.0));
    Color = aColor;
    Distance = -seen.z;
    gl_Position = projection * seen;
}
