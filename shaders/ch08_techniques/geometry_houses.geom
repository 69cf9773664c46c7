#version 330 core
layout (points) in;
layout (triangle_strip, max_vertices = 5) out;

in vec3 wall[];

uniform vec2 scale;

out vec3 fColor;

void corner(vec2 offset, vec3 color)
{
    gl_Position = gl_in[0].gl_Position + vec4(scale * offset, 0.0, 0.0);
    fColor = color;
    EmitVertex();
}

void main()
{
    corner(vec2(-1.0, -1.0), wall[0]);
    corner(vec2(1.0, -1.0), wall[0]);
    corner(vec2(-1.0, 1.0), wall[0]);
    corner(vec2(1.0, 1.0), wall[0]);
    corner(vec2(0.0, 2.0), vec3(1.0));   // snow on the roof
    EndPrimitive();
}
