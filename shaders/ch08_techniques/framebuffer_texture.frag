#version 330 core
in vec2 TexCoords;

uniform sampler2D screen;

out vec4 FragColor;

void main()
{
    // A screen on a wall: a dark rim, and inside of it what was drawn before.
    vec2 edge = min(TexCoords, 1.0 - TexCoords);
    vec4 picture = texture(screen, TexCoords);
    FragColor = min(edge.x, edge.y) < 0.03 ? vec4(0.07, 0.07, 0.09, 1.0) : picture;
}
