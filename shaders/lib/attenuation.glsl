// How a lamp's light decreases with distance.

struct Attenuation {
    float constant;
    float linear;
    float quadratic;
};

// The share of the light that is left at a distance.
float attenuationAt(Attenuation light, float distance)
{
    return 1.0 / (light.constant + light.linear * distance
                  + light.quadratic * (distance * distance));
}

// The inverse: the distance at which a fraction of the light is left.
float reachOf(Attenuation light, float fraction)
{
    float missing = 1.0 / fraction - light.constant;
    float root = sqrt(light.linear * light.linear + 4.0 * light.quadratic * missing);
    return 2.0 * missing / (light.linear + root);
}
