#version 330 core
#include "lib/energy.glsl"
#include "lib/drawing.glsl"

in vec2 place;              // about a ball of radius 1, seen from +z

uniform float roughness;
uniform vec3 f0;
uniform float later;
uniform vec3 lamps[3];      // directions, of unit length
uniform vec3 colors[3];
uniform float radius;       // of the ball, in pixels

out vec4 FragColor;

void main()
{
    float outward = dot(place, place);
    vec3 normal = vec3(place, sqrt(max(1.0 - outward, 0.0001)));
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 3; ++i)
        sum += colors[i] * metal(normal, vec3(0.0, 0.0, 1.0), lamps[i], roughness, f0, later);
    float edge = clamp(0.5 * radius * (1.0 - outward) + 0.5, 0.0, 1.0);
    vec3 behind = vec3(0.020, 0.024, 0.032) * (1.0 - 0.3 * place.y);
    FragColor = vec4(encoded(min(mix(behind, sum, edge), 1.0)), 1.0);
}
