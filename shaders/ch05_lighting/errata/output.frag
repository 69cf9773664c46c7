#version 330 core

out vec4 FragColor;

void main()
{
    vec3 output;
    output += vec3(1.0, 0.5, 0.31);
    FragColor = vec4(output, 1.0);
}
