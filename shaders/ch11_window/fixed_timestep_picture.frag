#version 330 core
#include "lib/drawing.glsl"

uniform vec3 hue;

out vec4 FragColor;

void main()
{
    if (length(gl_PointCoord - 0.5) > 0.5)
        discard;
    FragColor = vec4(encoded(hue), 1.0);
}
