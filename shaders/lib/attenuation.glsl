// Point light attenuation, shared by the curve and its picture.

struct Light {
    float constant;
    float linear;
    float quadratic;
};

// The share of the light that is left at a distance.
float attenuation(Light light, float distance)
{
    return 1.0 / (light.constant + light.linear * distance
                  + light.quadratic * (distance * distance));
}

// The inverse: the distance at which a fraction of the light is left.
float reachOf(Light light, float fraction)
{
    float missing = 1.0 / fraction - light.constant;
    float root = sqrt(light.linear * light.linear + 4.0 * light.quadratic * missing);
    return 2.0 * missing / (light.linear + root);
}
