#version 330 core

in float viewZ;   // negative in front of the camera

uniform float near;
uniform float far;

out vec2 depth;   // in device coordinates, and how it changes with viewZ

void main()
{
    float reach = 2.0 * far * near / (far - near);

    depth.x = (far + near) / (far - near) + reach / viewZ;
    depth.y = -reach / (viewZ * viewZ);
}
