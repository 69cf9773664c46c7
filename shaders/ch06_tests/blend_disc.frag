#version 330 core
in vec2 place;   // the target from −1 to 1

uniform vec2 centre;
uniform vec3 color;
uniform float alpha;

out vec4 FragColor;

void main()
{
    float distance = length(place - centre) - 0.55;
    float inside = 1.0 - smoothstep(0.0, 0.008, distance);
    FragColor = vec4(color, alpha * inside);
}
