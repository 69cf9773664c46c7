#version 330 core

#define WIDTH 720
#define WIDTH 640

out vec4 FragColor;

void main()
{
    FragColor = vec4(WIDTH);
}
