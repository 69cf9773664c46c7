#version 330 core
layout (location = 0) in vec3 aPos;          // on a mesh around the ball of radius 1
layout (location = 1) in vec3 lampPlace;     // of each instance
layout (location = 2) in vec3 lampColor;

uniform mat4 view;
uniform mat4 projection;
uniform float reach;

flat out vec3 LampPlace;
flat out vec3 LampColor;

void main()
{
    LampPlace = lampPlace;
    LampColor = lampColor;
    gl_Position = projection * (view * vec4(lampPlace + reach * aPos, 1.0));
}
