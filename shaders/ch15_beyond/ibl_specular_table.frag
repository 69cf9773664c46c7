#version 330 core
#include "lib/split_sum.glsl"

in float normalView;
in float roughness;

uniform vec2 azimuths[SAMPLES];

out vec2 factors;   // of f0, and what is added to it

float visible(float cosine)
{
    float k = 0.5 * roughness * roughness;
    return cosine / (cosine * (1.0 - k) + k);
}

void main()
{
    vec3 view = vec3(sqrt(1.0 - normalView * normalView), 0.0, normalView);
    vec2 sum = vec2(0.0);
    for (int i = 0; i < SAMPLES; ++i) {
        vec3 halfway = halfwayGGX(uint(i), azimuths[i], roughness);
        float viewHalf = max(dot(view, halfway), 0.0);
        float normalLight = max(2.0 * viewHalf * halfway.z - normalView, 0.0);
        float weight = visible(normalLight) * viewHalf / halfway.z;
        float grazing = 1.0 - viewHalf;
        float fresnel = grazing * grazing * (grazing * grazing) * grazing;
        sum += weight * vec2(1.0 - fresnel, fresnel);
    }
    factors = visible(normalView) / normalView / float(SAMPLES) * sum;
}
