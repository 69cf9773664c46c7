#version 330 core
layout (location = 0) in vec3 aPos;   // a square from −0.5 to 0.5

uniform float depth;   // −1 near … 1 far
uniform vec2 fields;   // how many fields of the table this draw covers, across and up

out vec2 place;

void main()
{
    place = (aPos.xy + 0.5) * fields;
    gl_Position = vec4(2.0 * aPos.xy, depth, 1.0);
}
