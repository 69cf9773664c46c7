#version 330 core
layout (triangles) in;
layout (triangle_strip, max_vertices = 3) out;

in vec3 place[];
in vec3 upright[];
in vec2 uv[];

uniform mat4 view;
uniform mat4 projection;

out vec3 FragPos;
out vec2 TexCoords;
out mat3 TBN;

void main()
{
    vec3 edge1 = place[1] - place[0];
    vec3 edge2 = place[2] - place[0];
    vec2 uv1 = uv[1] - uv[0];
    vec2 uv2 = uv[2] - uv[0];
    float determinant = uv1.x * uv2.y - uv2.x * uv1.y;   // below 0 where the picture is mirrored
    vec3 tangent = (uv2.y * edge1 - uv1.y * edge2) / determinant;

    for (int i = 0; i < 3; ++i) {
        vec3 N = normalize(upright[i]);
        vec3 T = normalize(tangent - dot(tangent, N) * N);
        vec3 B = cross(N, T) * sign(determinant);
        TBN = mat3(T, B, N);
        FragPos = place[i];
        TexCoords = uv[i];
        gl_Position = projection * (view * gl_in[i].gl_Position);
        EmitVertex();
    }
    EndPrimitive();
}
