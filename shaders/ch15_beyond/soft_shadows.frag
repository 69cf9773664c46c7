#version 330 core
#include "lib/drawing.glsl"
#include "lib/soft_shadow.glsl"

#define BALLS 4
#define CLOSER 1

in vec3 ray;

uniform sampler2D map;
uniform sampler2D means;
uniform vec2 points[POINTS];
uniform float lamp;
uniform vec4 balls[BALLS];
uniform vec3 eye;
uniform int way;

layout (location = 0) out vec4 FragColor;

void main()
{
    vec3 direction = normalize(ray);
    float nearest = -eye.y / direction.y;
    int met = -1;
    for (int k = 0; k < BALLS; ++k) {
        vec3 off = eye - balls[k].xyz;
        float beside = -dot(off, direction);
        vec3 apart = off + beside * direction;    // a small difference of large squares would err
        float square = balls[k].w * balls[k].w - dot(apart, apart);
        float away = beside - sqrt(max(square, 0.0));
        if (square > 0.0 && away < nearest) {
            nearest = away;
            met = k;
        }
    }
    vec3 place = eye + nearest * direction;
    vec3 light;
    if (met < 0) {
        vec2 at = 0.25 * place.xz + 0.5;
        float seen = way == CLOSER ? byCloser(map, at, points, lamp) : byVariance(means, at);
        vec3 tile = mix(vec3(0.62, 0.58, 0.52), vec3(0.50, 0.47, 0.43), chessboard(2.0 * place.xz));
        light = tile * (vec3(0.16, 0.18, 0.22) + seen * vec3(0.95, 0.88, 0.76));
    } else {
        vec3 normal = (place - balls[met].xyz) / balls[met].w;
        vec3 paint = 0.5 + 0.42 * cos(vec3(0.3, 2.3, 4.1) + 1.6 * float(met));
        light = paint * (0.34 + 0.14 * normal.y + 0.6 * max(normal.y, 0.0));
    }
    FragColor = vec4(encoded(light), 1.0);
}
