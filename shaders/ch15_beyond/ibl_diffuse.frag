#version 330 core
#include "lib/harmonics.glsl"

in vec3 Normal;

uniform sampler2D coefficients;   // nine texels
uniform vec3 albedo;

out vec4 FragColor;

void main()
{
    vec3 normal = normalize(Normal);
    vec3 irradiance = vec3(0.0);
    for (int k = 0; k < 9; ++k)
        irradiance += smoothing(k) * harmonic(k, normal) * texelFetch(coefficients, ivec2(k, 0), 0).rgb;
    FragColor = vec4(albedo / 3.141593 * irradiance, 1.0);
}
