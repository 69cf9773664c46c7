#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform bool leftHanded;   // z into the screen, as in normalised device coordinates
uniform mat4 view;
uniform mat4 projection;

out vec3 Normal;
out vec3 Color;
out vec3 Seen;

void main()
{
    vec3 hand = leftHanded ? vec3(1.0, 1.0, -1.0) : vec3(1.0);

    Seen = hand * aPos;
    Normal = hand * aNormal;
    Color = aColor;
    gl_Position = projection * (view * vec4(Seen, 1.0));
}
