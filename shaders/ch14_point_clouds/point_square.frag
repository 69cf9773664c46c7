#version 330 core
in float warmth;

out vec4 FragColor;

void main()
{
    // The whole square, so that its pixels can be counted.
    FragColor = vec4(warmth, 0.5, 1.0 - warmth, 1.0);
}
