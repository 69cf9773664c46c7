#version 330 core
in float decade;   // the logarithm to base 10 of the distance
in float height;   // 0 … 1 up the chart

uniform float near;
uniform float far;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float depth;

void main()
{
    float z = pow(10.0, decade);
    depth = (1.0 / z - 1.0 / near) / (1.0 / far - 1.0 / near);

    // Below the curve twenty shares of the codes, in turn light and dark; lines where z = 1, 10.
    // Half a share more, as mod may err in its division: of 2.0 it may be 2.0 as well as 0.0.
    float share = mod(floor(20.0 * depth) + 0.5, 2.0) - 0.5;
    vec3 below = mix(vec3(0.93, 0.62, 0.16), vec3(0.50, 0.27, 0.07), share);
    vec3 color = height < depth ? below : vec3(0.10, 0.13, 0.20);
    float line = min(abs(decade), abs(decade - 1.0));
    color = line < 0.004 ? vec3(0.75) : color;
    FragColor = vec4(height > 0.985 ? vec3(0.97) : color, 1.0);
}
