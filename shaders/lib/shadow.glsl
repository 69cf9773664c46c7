// Reading a shadow map: a point's depth, seen from the light, against the nearest one stored.

// From the light's clip space to texture coordinates and depth, all 0 … 1.
vec3 shadowCoordinates(vec4 lightSpace)
{
    return lightSpace.xyz / lightSpace.w * 0.5 + 0.5;
}

// A bias that grows as the light grazes the surface.
float slopeBias(vec3 normal, vec3 lightDir, float least, float most)
{
    return max(most * (1.0 - dot(normal, lightDir)), least);
}

// 1 in shadow, 0 in light; beyond the light's far plane nothing was stored, so nothing is dark.
float shadowOf(float current, float closest, float bias)
{
    if (current > 1.0)
        return 0.0;
    return current - bias > closest ? 1.0 : 0.0;
}

// The share of (2 radius + 1)² neighbouring texels that say shadow: comparisons, not depths, are
// averaged.
float ShadowCalculation(sampler2D shadowMap, vec3 place, float bias, int radius)
{
    vec2 texel = 1.0 / vec2(textureSize(shadowMap, 0));
    float sum = 0.0;
    for (int y = -radius; y <= radius; ++y)
        for (int x = -radius; x <= radius; ++x) {
            float closest = texture(shadowMap, place.xy + vec2(x, y) * texel).r;
            sum += shadowOf(place.z, closest, bias);
        }
    float side = float(2 * radius + 1);
    return sum / (side * side);
}
