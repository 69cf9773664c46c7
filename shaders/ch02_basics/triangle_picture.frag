#version 330 core
in vec2 place;

out vec4 FragColor;

void main()
{
    // The paper's lines show through, so that the corners' coordinates can be read off.
    vec2 field = abs(mod(place + 0.125, 0.25) - 0.125);
    float line = min(field.x, field.y) < 0.0028 ? 0.85 : 1.0;
    FragColor = vec4(line * vec3(1.0, 0.5, 0.2), 1.0);
}
