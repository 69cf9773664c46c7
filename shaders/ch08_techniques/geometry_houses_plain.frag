#version 330 core
in vec3 wall;

out vec4 FragColor;

void main()
{
    FragColor = vec4(wall, 1.0);
}
