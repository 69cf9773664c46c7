#version 330 core
in vec2 place;   // device coordinates

out vec4 FragColor;

void main()
{
    // Lines a quarter apart, the two axes brighter; a pixel of 720 is 1/360 wide.
    vec2 field = abs(mod(place + 0.125, 0.25) - 0.125);
    vec3 color = vec3(0.10, 0.14, 0.20);
    if (min(field.x, field.y) < 0.0028)
        color = vec3(0.20, 0.27, 0.36);
    if (min(abs(place.x), abs(place.y)) < 0.0056)
        color = vec3(0.62, 0.70, 0.78);
    FragColor = vec4(color, 1.0);
}
