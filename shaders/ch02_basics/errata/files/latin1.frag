#version 330 core
// Grün
out vec4 FragColor;

void main()
{
    FragColor = vec4(0.25, 0.5, 0.75, 1.0);
}
