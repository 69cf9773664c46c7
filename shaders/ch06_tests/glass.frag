#version 330 core
in vec2 place;   // the target from −1 to 1

uniform vec2 centre;
uniform float radius;
uniform vec4 color;

out vec4 FragColor;

void main()
{
    vec2 away = place - centre;
    if (dot(away, away) > radius * radius) {
        discard;
    }
    FragColor = color;
}
