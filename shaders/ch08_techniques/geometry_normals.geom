#version 330 core
layout (triangles) in;
layout (line_strip, max_vertices = 6) out;

in VS_OUT {
    vec3 normal;
} gs_in[];

uniform mat4 projection;
uniform float magnitude;

out float fraction;   // 0 at the foot of a normal, 1 at its tip

void main()
{
    for (int i = 0; i < 3; ++i) {
        for (int end = 0; end < 2; ++end) {
            vec4 offset = vec4(magnitude * float(end) * gs_in[i].normal, 0.0);
            gl_Position = projection * (gl_in[i].gl_Position + offset);
            fraction = float(end);
            EmitVertex();
        }
        EndPrimitive();
    }
}
