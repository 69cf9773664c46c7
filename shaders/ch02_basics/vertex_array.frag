#version 330 core
in float height;

out vec4 FragColor;

void main()
{
    FragColor = vec4(mix(vec3(0.16, 0.42, 0.55), vec3(1.0, 0.72, 0.30), height), 1.0);
}
