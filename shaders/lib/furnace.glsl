// What a mirror landscape that absorbs nothing (F = 1) reflects of a light that is 1 everywhere.

#define DIRECT 0
#define SKY 1
#define SMITH 2
#define LEVELS 16
#define RING 8

// One half of G, in three forms: k for lamps, k for light from everywhere, and GGX's own.
float halfOfG(int form, float cosine, float roughness)
{
    float alpha = roughness * roughness;
    if (form == SMITH) {
        float alpha2 = alpha * alpha;
        return 2.0 * cosine / (cosine + sqrt(alpha2 + (1.0 - alpha2) * (cosine * cosine)));
    }
    float grown = roughness + 1.0;
    float k = form == DIRECT ? grown * grown / 8.0 : 0.5 * alpha;
    return cosine / (cosine * (1.0 - k) + k);
}

// Halfway vectors are chosen as D is distributed, so D itself has cancelled. `ring` holds cosines
// of azimuths from 0 to π; the other side gives the same.
float reflectedShare(int form, float normalView, float roughness, float ring[RING])
{
    float alpha = roughness * roughness;
    float alpha2 = alpha * alpha;
    float sineView = sqrt(max(1.0 - normalView * normalView, 0.0));
    float total = 0.0;
    for (int level = 0; level < LEVELS; ++level) {
        float u = (float(level) + 0.5) / float(LEVELS);
        float around = 1.0 - u + alpha2 * u;
        float cosine = sqrt((1.0 - u) / around);
        float sine = sqrt(alpha2 * u / around);
        for (int i = 0; i < RING; ++i) {
            float viewHalf = max(sineView * sine * ring[i] + normalView * cosine, 0.0);
            float normalLight = max(2.0 * viewHalf * cosine - normalView, 0.0);
            total += halfOfG(form, normalLight, roughness) * viewHalf / cosine;
        }
    }
    return total * halfOfG(form, normalView, roughness) / normalView / float(LEVELS * RING);
}
