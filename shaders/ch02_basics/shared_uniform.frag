#version 330 core
out vec4 FragColor;
uniform float level;

void main()
{
    FragColor = vec4(vec3(level), 1.0);
}
