#version 330 core
layout (origin_upper_left) in vec4 gl_FragCoord;

layout (location = 0) out vec2 place;

void main()
{
    place = gl_FragCoord.xy;   // the same, counted from the upper left corner downwards
}
