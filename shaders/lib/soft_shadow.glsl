// How much of a round lamp, high above a floor, is seen from a place on the floor.

#define POINTS 32
#define HIGHEST 1.1

// Variance (Donnelly & Lauritzen 2006): a mean height and a mean square say how large a share can be
// as low as the floor, at most. That is Chebyshev's inequality.
float byVariance(sampler2D means, vec2 at)
{
    vec2 mean = texture(means, at).rg;
    float variance = max(mean.y - mean.x * mean.x, 0.0);
    return mean.y > 0.0 ? variance / mean.y : 1.0;
}

// Percentage-closer soft shadows (Fernando 2005): how high is what is in the way, and how much of
// the lamp does it then hide?
float byCloser(sampler2D map, vec2 at, vec2 points[POINTS], float lamp)
{
    float heights = 0.0;
    float blockers = 0.0;
    for (int k = 0; k < POINTS; ++k) {
        float height = textureLod(map, at + lamp * HIGHEST * points[k], 0.0).r;
        heights += height;
        blockers += sign(height);
    }
    if (blockers == 0.0)
        return 1.0;
    float size = lamp * heights / blockers;
    float seen = 0.0;
    for (int k = 0; k < POINTS; ++k)
        seen += 1.0 - sign(textureLod(map, at + size * points[k], 0.0).r);
    return seen / float(POINTS);
}
