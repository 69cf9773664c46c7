#version 330 core
in float fraction;

out vec4 FragColor;

void main()
{
    FragColor = vec4(mix(vec3(0.95, 0.75, 0.15), vec3(0.85, 0.15, 0.1), fraction), 1.0);
}
