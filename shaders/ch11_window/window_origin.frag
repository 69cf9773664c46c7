#version 330 core
layout (location = 0) out vec2 place;

void main()
{
    place = gl_FragCoord.xy;   // the pixel's centre, in pixels from the lower left corner
}
