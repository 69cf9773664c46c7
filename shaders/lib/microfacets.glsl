// The three factors of a microfacet reflectance. Directions are of unit length.

const float PI = 3.14159265359;

// D, Trowbridge–Reitz or GGX: how many of the tiny mirrors face the halfway vector.
float distributionGGX(vec3 normal, vec3 halfway, float roughness)
{
    float alpha = roughness * roughness;
    float alpha2 = alpha * alpha;
    float cosine = dot(normal, halfway);
    // |n × h|² instead of 1 − (n·h)²: nothing cancels where the two are close.
    vec3 aside = cross(normal, halfway);
    float bracket = alpha2 * cosine * cosine + dot(aside, aside);
    return alpha2 / (PI * bracket * bracket);
}

float geometrySchlickGGX(float cosine, float roughness)
{
    float grown = roughness + 1.0;
    float k = grown * grown / 8.0;
    return cosine / (cosine * (1.0 - k) + k);
}

// G, Smith: the share of mirrors that both the viewer and the light can see.
float geometrySmith(float normalView, float normalLight, float roughness)
{
    return geometrySchlickGGX(normalView, roughness) * geometrySchlickGGX(normalLight, roughness);
}

// F, Schlick: f0 straight on, everything at a grazing angle.
vec3 fresnelSchlick(float cosine, vec3 f0)
{
    float grazing = 1.0 - cosine;
    float grazing2 = grazing * grazing;
    return f0 + (1.0 - f0) * (grazing2 * grazing2 * grazing);
}
