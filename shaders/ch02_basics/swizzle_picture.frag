#version 330 core
#include "lib/drawing.glsl"

in vec2 place;   // −1…1 over one field

uniform int order;   // which of the six orders of r, g and b

out vec4 FragColor;

// How much light a round lamp throws on a wall.
float lamp(vec2 at)
{
    return 1.0 - smoothstep(0.42, 0.48, length(place - at));
}

void main()
{
    // Red above, green at the lower left, blue at the lower right.
    vec3 c = vec3(lamp(vec2(0.0, 0.30)), lamp(vec2(-0.28, -0.18)), lamp(vec2(0.28, -0.18)));
    vec3 light = c.rgb;
    if (order == 1)
        light = c.gbr;
    else if (order == 2)
        light = c.brg;
    else if (order == 3)
        light = c.rbg;
    else if (order == 4)
        light = c.grb;
    else if (order == 5)
        light = c.bgr;
    vec3 color = mix(vec3(0.004, 0.005, 0.008), vec3(1.0), light);
    FragColor = vec4(encoded(color * step(max(abs(place.x), abs(place.y)), 0.97)), 1.0);
}
