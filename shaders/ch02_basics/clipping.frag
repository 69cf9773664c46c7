#version 330 core
in vec4 place;

uniform vec3 nearColor;
uniform vec3 farColor;

out vec4 FragColor;

void main()
{
    float depth = place.z / place.w;   // -1 at the near plane, 1 at the far one
    FragColor = vec4(mix(nearColor, farColor, 0.5 + 0.5 * depth), 1.0);
}
