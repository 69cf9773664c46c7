// Transfer curves between light and the numbers a display expects.

float gammaEncode(float linear, float gamma)
{
    return pow(linear, 1.0 / gamma);
}

float srgbEncode(float linear)
{
    if (linear <= 0.0031308)
        return 12.92 * linear;
    return 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
}

float srgbDecode(float encoded)
{
    if (encoded <= 0.04045)
        return encoded / 12.92;
    return pow((encoded + 0.055) / 1.055, 2.4);
}
