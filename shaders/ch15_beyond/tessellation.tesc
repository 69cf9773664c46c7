#version 400 core
layout (vertices = 3) out;

uniform vec3 near;      // where the division is finest
uniform float finest;

// By the middle of an edge alone: both patches that share it divide it alike.
float levelOf(vec3 one, vec3 other)
{
    return clamp(finest / (0.25 + distance(near, 0.5 * (one + other))), 1.0, 32.0);
}

void main()
{
    gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;
    vec3 a = gl_in[0].gl_Position.xyz;
    vec3 b = gl_in[1].gl_Position.xyz;
    vec3 c = gl_in[2].gl_Position.xyz;
    gl_TessLevelOuter[0] = levelOf(b, c);       // opposite to the first corner
    gl_TessLevelOuter[1] = levelOf(c, a);
    gl_TessLevelOuter[2] = levelOf(a, b);
    gl_TessLevelInner[0] = max(max(gl_TessLevelOuter[0], gl_TessLevelOuter[1]), gl_TessLevelOuter[2]);
}
