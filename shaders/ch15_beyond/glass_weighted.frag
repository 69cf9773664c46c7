#version 330 core
#include "lib/glass.glsl"

in vec2 place;

uniform Petal petal;
uniform float pixel;

// Blended: colours are added up, alphas multiplied as 1 − α.
layout (location = 0) out vec4 light;
layout (location = 1) out vec4 weight;

void main()
{
    float alpha = cover(petal, place, pixel);
    float nearness = 1.0 - depthOf(petal, place);
    float weighted = alpha * clamp(30.0 * nearness * nearness * nearness, 0.01, 300.0);
    light = vec4(weighted * petal.color, alpha);
    weight = vec4(weighted, 0.0, 0.0, alpha);
}
