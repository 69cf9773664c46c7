#version 330 core
layout (triangles) in;
layout (triangle_strip, max_vertices = 3) out;

in VS_OUT {
    vec3 world;
    vec3 color;
} gs_in[];

uniform mat4 view;
uniform mat4 projection;
uniform float time;

out vec3 fColor;
out vec3 fNormal;

void main()
{
    vec3 a = gs_in[1].world - gs_in[0].world;
    vec3 b = gs_in[2].world - gs_in[0].world;
    vec3 normal = normalize(cross(a, b));   // outwards: corners run counter-clockwise
    float magnitude = 0.5 * (sin(time) + 1.0);
    for (int i = 0; i < 3; ++i) {
        gl_Position = projection * (view * vec4(gs_in[i].world + magnitude * normal, 1.0));
        fColor = gs_in[i].color;
        fNormal = normal;
        EmitVertex();
    }
    EndPrimitive();
}
