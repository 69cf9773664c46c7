#version 330 core
in float Distance;

uniform float near;
uniform float far;

out float F;   // what the depth buffer should hold

void main()
{
    F = (1.0 / Distance - 1.0 / near) / (1.0 / far - 1.0 / near);
}
