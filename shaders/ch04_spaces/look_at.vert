#version 330 core
#include "lib/look_at.glsl"
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform vec3 eye;
uniform vec3 target;
uniform vec3 up;
uniform mat4 projection;

out vec3 Normal;
out vec3 Color;
out vec3 InView;   // as the camera sees it: x to its right, y up, z towards it

void main()
{
    vec4 place = lookAt(eye, target, up) * vec4(aPos, 1.0);

    InView = place.xyz;
    Normal = aNormal;   // the light is the world's
    Color = aColor;
    gl_Position = projection * place;
}
