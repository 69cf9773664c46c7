#version 330 core

uniform vec3 glow;   // a lamp is not lit, it shines

out vec4 FragColor;

void main()
{
    FragColor = vec4(glow, 1.0);
}
