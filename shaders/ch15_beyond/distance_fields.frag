#version 330 core
#include "lib/solids.glsl"
#include "lib/drawing.glsl"

in vec3 ray;                // from the eye, of any length

uniform vec3 eye;
uniform vec3 lamp;          // its direction, of unit length

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float far;     // along the ray; 24 and more in the sky

// Towards where distances grow fastest, from four places around.
vec3 outward(vec3 place)
{
    vec2 k = vec2(0.5773, -0.5773);
    return normalize(k.xyy * toScene(place + 0.001 * k.xyy) + k.yyx * toScene(place + 0.001 * k.yyx)
                   + k.yxy * toScene(place + 0.001 * k.yxy) + k.xxx * toScene(place + 0.001 * k.xxx));
}

// How much of a wide lamp is seen: as narrow as the narrowest passage on the way.
float unshaded(vec3 place)
{
    float open = 1.0;
    float along = 0.03;
    for (int i = 0; i < 24; ++i) {
        float away = toScene(place + along * lamp);
        open = min(open, 9.0 * away / along);
        along += clamp(away, 0.04, 0.35);
    }
    open = clamp(open, 0.0, 1.0);
    return open * open * (3.0 - 2.0 * open);
}

void main()
{
    vec3 direction = normalize(ray);
    far = 0.0;
    float away = 1.0;
    for (int i = 0; i < 72 && far < 24.0 && away > 0.0001; ++i) {
        away = toScene(eye + far * direction);
        far += away;
    }

    vec3 sky = mix(vec3(0.62, 0.75, 0.92), vec3(0.16, 0.33, 0.66), clamp(2.0 * direction.y, 0.0, 1.0));
    vec3 color = sky;
    if (far < 24.0) {
        vec3 place = eye + far * direction;
        vec3 normal = outward(place);
        float above = step(0.01, place.y);
        vec3 floorColor = vec3(0.55 - 0.23 * chessboard(place.xz));
        vec3 hue = mix(floorColor, 0.5 + 0.4 * cos(1.5 * place.x + vec3(0.2, 1.7, 2.9)), above);
        // What lies a little way out of a corner is nearer to it than that.
        float open = clamp(0.4 + 2.4 * toScene(place + 0.25 * normal), 0.0, 1.0);
        float light = max(dot(normal, lamp), 0.0) * unshaded(place + 0.002 * normal);
        vec3 gloss = 0.35 * above * pow(max(dot(reflect(direction, normal), lamp), 0.0), 40.0) * vec3(light);
        color = hue * (light * vec3(1.15, 1.02, 0.85) + open * (0.25 + 0.2 * normal.y) * sky) + gloss;
        color = mix(color, sky, smoothstep(10.0, 24.0, far));
    }
    FragColor = vec4(encoded(min(color, 1.0)), 1.0);
}
