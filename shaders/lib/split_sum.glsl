// Light from everywhere on a glossy surface, in two sums over halfway vectors (Karis 2013).

#define SAMPLES 32

// The bits of i in opposite order, as a binary fraction: evenly spread over 0 … 1 for any count.
uint reversed(uint bits)
{
    bits = (bits << 16u) | (bits >> 16u);
    bits = ((bits & 0x00ff00ffu) << 8u) | ((bits & 0xff00ff00u) >> 8u);
    bits = ((bits & 0x0f0f0f0fu) << 4u) | ((bits & 0xf0f0f0f0u) >> 4u);
    bits = ((bits & 0x33333333u) << 2u) | ((bits & 0xccccccccu) >> 2u);
    return ((bits & 0x55555555u) << 1u) | ((bits & 0xaaaaaaaau) >> 1u);
}

// A halfway vector about +z, chosen as GGX's D (n·h) is distributed; `azimuth` is of unit length.
vec3 halfwayGGX(uint i, vec2 azimuth, float roughness)
{
    float u = float(reversed(i)) * 2.3283064365386963e-10;
    float alpha2 = roughness * roughness * roughness * roughness;
    float around = 1.0 - u + alpha2 * u;
    return vec3(sqrt(alpha2 * u / around) * azimuth, sqrt((1.0 - u) / around));
}
