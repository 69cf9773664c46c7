#version 330 core
in vec2 place;

uniform vec2 jitter;      // how far the camera is shifted
uniform vec2 spokes[12];  // directions, evenly around

out vec4 FragColor;

const vec2 HUB = vec2(0.0, 0.12);

// A Ferris wheel in the evening; nothing in it has a soft edge.
void main()
{
    vec2 at = place + jitter;
    vec3 color = mix(vec3(0.98, 0.72, 0.48), vec3(0.36, 0.45, 0.70), clamp(0.5 * at.y + 0.55, 0.0, 1.0));
    if (at.y < -0.80)
        color = vec3(0.13, 0.16, 0.20);
    vec2 off = at - HUB;
    float along = abs(off.x) + 0.42 * off.y;      // of the stand, 0 on its legs
    if (abs(along) < 0.034 && off.y < 0.0)
        color = vec3(0.16, 0.17, 0.24);
    float away = length(off);
    for (int k = 0; k < 6; ++k) {
        if (abs(spokes[k].x * off.y - spokes[k].y * off.x) < 0.012 && away < 0.66)
            color = vec3(0.95, 0.93, 0.88);
    }
    if (abs(away - 0.66) < 0.026 || abs(away - 0.36) < 0.014 || away < 0.07)
        color = vec3(0.95, 0.93, 0.88);
    for (int k = 0; k < 12; ++k) {
        vec2 gondola = off - 0.66 * spokes[k] + vec2(0.0, 0.05);
        if (length(gondola) < 0.085)
            color = k % 3 == 0 ? vec3(0.80, 0.14, 0.14)
                  : k % 3 == 1 ? vec3(0.96, 0.76, 0.18) : vec3(0.10, 0.42, 0.50);
    }
    FragColor = vec4(color, 1.0);
}
