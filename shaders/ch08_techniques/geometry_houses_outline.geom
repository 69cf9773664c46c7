#version 330 core
layout (points) in;
layout (line_strip, max_vertices = 6) out;

in vec3 wall[];

uniform vec2 scale;

out vec3 fColor;

void corner(vec2 offset)
{
    gl_Position = gl_in[0].gl_Position + vec4(scale * offset, 0.0, 0.0);
    fColor = 0.4 * wall[0];
    EmitVertex();
}

void main()
{
    corner(vec2(-1.0, -1.0));
    corner(vec2(1.0, -1.0));
    corner(vec2(1.0, 1.0));
    corner(vec2(0.0, 2.0));
    corner(vec2(-1.0, 1.0));
    corner(vec2(-1.0, -1.0));
    EndPrimitive();
}
