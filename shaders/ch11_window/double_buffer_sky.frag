#version 330 core
in vec2 place;   // −1…1

out vec4 FragColor;

void main()
{
    vec3 sky = mix(vec3(0.80, 0.62, 0.52), vec3(0.22, 0.34, 0.55), 0.5 + 0.5 * place.y);
    FragColor = vec4(place.y < -0.5 ? vec3(0.16, 0.24, 0.20) : sky, 1.0);
}
