#version 330 core
layout (location = 0) in vec3 aPos;

uniform mat4 model;
uniform mat4 projection;
uniform vec3 axes;   // half axes a, b, c

out vec3 Local;      // the point in the ellipsoid's own frame
out vec3 gradient;

void main()
{
    Local = aPos;
    gradient = 2.0 * aPos / (axes * axes);
    gl_Position = projection * (model * vec4(aPos, 1.0));
}
