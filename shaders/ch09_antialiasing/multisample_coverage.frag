#version 330 core
in vec2 at;   // pixels of the multisampled target

uniform sampler2D resolved;
uniform sampler2DMS samples;
uniform sampler2DMS places;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float coverage;   // what resolving made of the samples
layout (location = 2) out vec4 each;        // the four samples themselves
layout (location = 3) out vec4 placesX;
layout (location = 4) out vec4 placesY;

void main()
{
    ivec2 pixel = ivec2(floor(at));
    vec2 within = fract(at);
    coverage = texelFetch(resolved, pixel, 0).r;
    vec3 color = mix(vec3(0.10, 0.13, 0.20), vec3(0.93, 0.90, 0.80), coverage);
    float grid = min(min(within.x, within.y), min(1.0 - within.x, 1.0 - within.y));
    color = grid < 0.02 ? vec3(0.45) : color;
    for (int k = 0; k < 4; ++k) {
        float one = texelFetch(samples, pixel, k).r;
        vec2 place = texelFetch(places, pixel, k).xy;
        each[k] = one;
        placesX[k] = place.x;
        placesY[k] = place.y;
        vec3 dot_ = one > 0.5 ? vec3(0.95, 0.55, 0.10) : vec3(0.30, 0.55, 0.75);
        color = length(within - place) < 0.07 ? dot_ : color;
    }
    FragColor = vec4(color, 1.0);
}
