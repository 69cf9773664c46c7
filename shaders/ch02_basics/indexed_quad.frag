#version 330 core
in vec2 place;

out vec4 FragColor;

void main()
{
    // The first triangle is amber, the second one teal, so that the shared edge can be seen.
    if (place.x + place.y > 0.0)
        FragColor = vec4(1.0, 0.625, 0.25, 1.0);
    else
        FragColor = vec4(0.25, 0.625, 0.625, 1.0);
}
