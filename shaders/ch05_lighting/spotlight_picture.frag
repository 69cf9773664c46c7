#version 330 core
#include "lib/spotlight.glsl"
#include "lib/drawing.glsl"

in vec3 FragPos;   // a slice through the beam, the light at its top

uniform Spot light;

out vec4 FragColor;

const vec3 AIR = vec3(0.02, 0.03, 0.05);
const vec3 BEAM = vec3(1.0, 0.93, 0.75);

void main()
{
    float ratio = spotRatio(light, FragPos);
    float intensity = spotIntensity(light, FragPos);
    float distance = length(light.position - FragPos);

    vec3 color = encoded(min(AIR + BEAM * 0.55 * intensity / (0.4 + distance * distance), 1.0));
    float inFront = step(0.05, distance);
    color = mix(color, vec3(1.00, 0.72, 0.25), inFront * line(ratio - 1.0, 1.5));
    color = mix(color, vec3(0.45, 0.70, 1.00), inFront * line(ratio, 1.5));
    color = mix(color, vec3(0.85), 0.35 * line(distance - 1.0, 1.0));
    FragColor = vec4(color, 1.0);
}
