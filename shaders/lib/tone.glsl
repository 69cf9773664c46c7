// From light without an upper end to the range of a display.

vec3 reinhard(vec3 light)
{
    return light / (1.0 + light);
}

vec3 exposed(vec3 light, float exposure)
{
    return 1.0 - exp(-light * exposure);
}
