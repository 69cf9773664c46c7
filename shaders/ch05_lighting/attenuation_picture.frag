#version 330 core
#include "lib/attenuation.glsl"
#include "lib/drawing.glsl"

in vec2 FragPos;   // on the floor, the light in the middle

uniform Attenuation light;
uniform float coverage;   // the table's d

out vec4 FragColor;

const vec3 LAMP = vec3(1.0, 0.87, 0.66);

void main()
{
    float distance = length(FragPos);
    vec3 floorColor = mix(vec3(0.55), vec3(0.75), chessboard(FragPos * 10.0 / coverage));
    vec3 color = encoded(floorColor * LAMP * attenuationAt(light, distance));

    color = mix(color, vec3(1.00, 0.72, 0.25), line(distance - reachOf(light, 0.05), 2.0));
    color = mix(color, vec3(0.45, 0.70, 1.00), line(distance - reachOf(light, 0.01), 2.0));
    color = mix(color, vec3(1.00, 1.00, 1.00), 0.6 * line(distance - coverage, 1.0));
    FragColor = vec4(color, 1.0);
}
