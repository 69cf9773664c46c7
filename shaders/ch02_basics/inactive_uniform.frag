#version 330 core
uniform vec3 tint;
uniform float strength;
uniform float unused;      // declared, and that is all
uniform vec2 neverAsked;   // read only by a function that nobody calls

out vec4 FragColor;

float elsewhere()
{
    return neverAsked.x + neverAsked.y;
}

void main()
{
    FragColor = vec4(strength * tint, 1.0);
}
