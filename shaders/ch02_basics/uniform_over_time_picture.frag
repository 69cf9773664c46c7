#version 330 core
#include "lib/drawing.glsl"

in vec2 place;   // x: time in seconds, y: green

uniform vec4 ourColor;
uniform float time;

out vec4 FragColor;

void main()
{
    float pulse = sin(place.x) / 2.0 + 0.5;

    // Behind the curve is the colour that the uniform has had, or will have, at that time.
    vec3 color = vec3(0.07, 0.08, 0.10);
    if (place.y < pulse && place.y > 0.0)
        color = vec3(0.0, pulse, 0.0) * (place.x < time ? 0.75 : 0.30);
    color = mix(color, vec3(0.30), line(place.y, 1.0) + line(place.y - 1.0, 1.0));
    color = mix(color, vec3(0.85), line(place.y - pulse, 2.0));
    color = mix(color, vec3(0.85), 0.5 * line(place.x - time, 1.0));

    // The bead is where we are now, filled with the uniform itself.
    vec2 bead = (place - vec2(time, ourColor.g)) * vec2(0.2254, 1.0);
    float distance = length(bead) - 0.075;
    if (distance < 0.0)
        color = ourColor.rgb;
    color = mix(color, vec3(1.0), line(distance, 2.5));
    FragColor = vec4(color, 1.0);
}
