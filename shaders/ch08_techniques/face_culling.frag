#version 330 core
out vec4 FragColor;

void main()
{
    FragColor = gl_FrontFacing ? vec4(1.0, 0.625, 0.25, 1.0) : vec4(0.25, 0.5, 0.75, 1.0);
}
