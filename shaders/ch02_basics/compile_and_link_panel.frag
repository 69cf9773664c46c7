#version 330 core
in vec2 place;   // −1…1 over the panel

uniform vec3 lamps[3];   // vertex shader, fragment shader, link: a colour for what became of it

out vec4 FragColor;

void main()
{
    vec3 color = vec3(0.10, 0.13, 0.18);
    if (max(abs(place.x), abs(place.y)) > 0.96)
        color = vec3(0.05, 0.06, 0.08);

    // The triangle that the program would draw, as an empty outline.
    float inside = min(place.y + 0.3, 0.7 - place.y - 2.0 * abs(place.x));
    if (inside > 0.0 && inside < 0.04)
        color = vec3(0.30, 0.36, 0.44);

    // Three lamps on a wire: nothing behind a red one is reached.
    if (abs(place.x) < 0.5 && abs(place.y + 0.65) < 0.02)
        color = vec3(0.36, 0.42, 0.50);
    for (int i = 0; i < 3; ++i) {
        vec2 off = place - vec2(0.5 * float(i) - 0.5, -0.65);
        if (dot(off, off) < 0.0225)
            color = lamps[i];
    }
    FragColor = vec4(color, 1.0);
}
