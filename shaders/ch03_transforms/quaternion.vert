#version 330 core
#include "lib/quaternion.glsl"
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform vec4 from;   // unit quaternions: xyz the axis times sin φ/2, w cos φ/2
uniform vec4 to;
uniform float t;
uniform vec3 away;   // where the thing is before it turns
uniform mat4 view;
uniform mat4 projection;

out vec3 Normal;
out vec3 Color;
out vec4 Orientation;
out vec3 Turned;

vec4 slerp(vec4 a, vec4 b, float t)
{
    float angle = acos(dot(a, b));
    return (sin((1.0 - t) * angle) * a + sin(t * angle) * b) / sin(angle);
}

void main()
{
    Orientation = slerp(from, to, t);
    Turned = turned(aPos + away, Orientation);
    Normal = turned(aNormal, Orientation);
    Color = aColor;
    gl_Position = projection * (view * vec4(Turned, 1.0));
}
