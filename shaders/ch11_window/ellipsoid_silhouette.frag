#version 330 core
in vec2 plane;   // the view plane, in the units of the half axes

uniform sampler2D covered;   // 1 where the mesh is

layout (location = 0) out float inside;

void main()
{
    inside = texture(covered, plane / vec2(2.1, 1.68) + 0.5).r;
}
