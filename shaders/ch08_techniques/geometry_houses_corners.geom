#version 330 core
layout (points) in;
layout (points, max_vertices = 2) out;

in vec3 wall[];

uniform vec2 scale;

out vec3 fColor;

void main()
{
    for (int i = 0; i < 2; ++i) {   // two windows
        vec2 offset = vec2(i == 0 ? -0.5 : 0.5, 0.25);
        gl_Position = gl_in[0].gl_Position + vec4(scale * offset, 0.0, 0.0);
        gl_PointSize = 12.0;
        fColor = vec3(1.0, 0.95, 0.6) - 0.25 * wall[0];
        EmitVertex();
        EndPrimitive();
    }
}
