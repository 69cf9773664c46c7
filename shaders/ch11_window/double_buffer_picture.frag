#version 330 core
in vec2 place;   // 0…1 over one screen

uniform sampler2D seen;
uniform vec3 edge;

out vec4 FragColor;

void main()
{
    vec2 off = abs(place - 0.5);
    vec3 shown = texture(seen, (place - 0.5) / 0.92 + 0.5).rgb;
    FragColor = vec4(max(off.x, off.y) > 0.46 ? edge : shown, 1.0);
}
