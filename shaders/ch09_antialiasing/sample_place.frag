#version 330 core
out vec2 place;   // where in its pixel this invocation stands

void main()
{
    place = fract(gl_FragCoord.xy);
}
