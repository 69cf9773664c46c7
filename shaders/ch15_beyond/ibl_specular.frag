#version 330 core
#include "lib/split_sum.glsl"
#include "lib/drawing.glsl"

in vec2 place;           // about a ball of radius 1

uniform vec2 azimuths[SAMPLES];
uniform samplerCube sky;
uniform sampler2D table;    // the two factors, over n·v and roughness
uniform vec3 f0;
uniform float roughness;
uniform mat3 camera;        // its axes: right, up, backward
uniform vec2 aside;         // where the ball stands, as a slope
uniform float radius;       // of the ball, in pixels

out vec4 FragColor;

// The sky around a direction, as blurred as a surface of this roughness shows it from above.
vec3 blurred(vec3 axis, float roughness)
{
    vec3 aside = normalize(cross(abs(axis.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), axis));
    vec3 upward = cross(axis, aside);
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int i = 0; i < SAMPLES; ++i) {
        vec3 local = halfwayGGX(uint(i), azimuths[i], roughness);
        vec3 halfway = local.x * aside + local.y * upward + local.z * axis;
        float weight = 2.0 * local.z * local.z - 1.0;
        if (weight > 0.0) {
            sum += weight * textureLod(sky, 2.0 * local.z * halfway - axis, 7.0 * roughness).rgb;
            weights += weight;
        }
    }
    return sum / weights;
}

void main()
{
    float outward = dot(place, place);
    float facing = sqrt(max(1.0 - outward, 0.0001));
    vec3 axis = camera * vec3(2.0 * facing * place, 1.0 - 2.0 * outward);
    vec2 factors = texture(table, vec2(facing, roughness)).rg;
    vec3 ball = blurred(axis, roughness) * (f0 * factors.x + factors.y);
    vec3 behind = textureLod(sky, camera * vec3(aside + 0.125 * place, -1.0), 3.0).rgb;
    float edge = clamp(0.5 * radius * (1.0 - outward) + 0.5, 0.0, 1.0);
    FragColor = vec4(encoded(min(mix(behind, ball, edge), 1.0)), 1.0);
}
