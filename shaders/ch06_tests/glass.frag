#version 330 core
in vec2 place;   // the target from −1 to 1

uniform vec2 centre;
uniform float radius;
uniform vec4 color;

out vec4 FragColor;

void main()
{
    vec2 offset = place - centre;
    if (dot(offset, offset) > radius * radius) {
        discard;
    }
    FragColor = color;
}
