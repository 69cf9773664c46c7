#version 400 core
layout (triangles, equal_spacing, ccw) in;

uniform mat4 view;
uniform mat4 projection;
uniform float roundness;    // 0: the flat faces, 1: the ball

out vec3 Place;
flat out vec3 Facet;     // where one corner of the triangle is
out vec3 Corner;        // weights of the patch's corners; their sum is 1

void main()
{
    Corner = gl_TessCoord;
    vec3 face = gl_TessCoord.x * gl_in[0].gl_Position.xyz + gl_TessCoord.y * gl_in[1].gl_Position.xyz
               + gl_TessCoord.z * gl_in[2].gl_Position.xyz;
    Place = mix(face, normalize(face), roundness);
    Facet = Place;
    gl_Position = projection * (view * vec4(Place, 1.0));
}
