#version 330 core
layout (location = 0) in vec3 aPos;   // −1 … 1 over the strip

uniform mat4 projection;
uniform float middle;   // distance in the middle of the strip
uniform float slope;    // how much farther the right edge is than the middle

out float Distance;

void main()
{
    // Whatever its distance, a point stays where it is on the screen.
    Distance = middle + slope * aPos.x;
    gl_Position = projection * vec4(0.0, 0.0, -Distance, 1.0);
    gl_Position.xy = aPos.xy * gl_Position.w;
}
