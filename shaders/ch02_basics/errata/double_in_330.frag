#version 330 core
uniform dvec2 pair;

out vec4 FragColor;

void main()
{
    FragColor = vec4(pair, 0.0, 1.0);
}
