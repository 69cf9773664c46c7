#version 330 core
#include "lib/furnace.glsl"
#include "lib/drawing.glsl"

in vec2 TexCoords;

uniform float ring[RING];
uniform float light;      // of the furnace, as much as still leaves room above it

out vec4 FragColor;

// Six balls in each of three rows: the light that a ball sends back to a viewer far away.
void main()
{
    vec2 place = 6.0 * TexCoords - vec2(0.0, 0.51);
    int row = int(clamp(floor(place.y / 1.66), 0.0, 2.0));
    vec2 local = vec2(fract(place.x) - 0.5, place.y - 1.66 * (float(row) + 0.5)) / 0.46;
    float outwards = length(local);

    float roughness = 0.15 + 0.17 * floor(place.x);
    float normalView = max(sqrt(max(1.0 - outwards * outwards, 0.0)), 0.02);
    float edge = clamp((1.0 - outwards) / fwidth(outwards) + 0.5, 0.0, 1.0);
    float share = 1.0;
    if (outwards < 1.05)
        share = reflectedShare(row, normalView, roughness, ring);
    FragColor = vec4(encoded(light * vec3(1.0, 0.95, 0.87) * mix(1.0, share, edge)), 1.0);
}
