#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in float aWarmth;

uniform mat4 view;
uniform mat4 projection;
uniform float pointScale;   // a point's diameter in pixels at distance 1

out float warmth;
out float diameter;

void main()
{
    warmth = aWarmth;
    gl_Position = projection * (view * vec4(aPos, 1.0));

    // Clip w is the distance along the view direction: twice as far is half as wide.
    diameter = pointScale / gl_Position.w;
    gl_PointSize = diameter;
}
