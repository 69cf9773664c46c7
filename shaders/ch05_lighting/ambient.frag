#version 330 core

uniform vec3 objectColor;
uniform vec3 lightColor;
uniform float ambientStrength;

out vec4 FragColor;

void main()
{
    vec3 ambient = ambientStrength * lightColor;
    FragColor = vec4(ambient * objectColor, 1.0);
}
