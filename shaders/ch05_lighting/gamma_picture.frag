#version 330 core
#include "lib/gamma.glsl"

in float linear;
in float stripe;   // 0 at the bottom … 5 at the top

out vec4 FragColor;

// Thresholds of an 8 × 8 ordered dither, 1/128 … 127/128 (B. E. Bayer, 1973).
float threshold(ivec2 pixel)
{
    float level = 0.0;
    for (int bit = 0; bit < 3; ++bit) {
        int x = (pixel.x >> bit) & 1;
        int y = (pixel.y >> bit) & 1;
        level = level + float((x ^ y) * 2 + y) / pow(4.0, float(bit + 1));
    }
    return level + 1.0 / 128.0;
}

void main()
{
    float light = (floor(linear * 24.0) + 0.5) / 24.0;
    // Dots of 2 × 2 pixels, so that they survive a picture that is shown a little smaller.
    float dithered = step(threshold(ivec2(gl_FragCoord.xy) / 2), light);

    // Five stripes: raw, dithered, encoded, dithered, raw.
    float shown = dithered;
    if (stripe < 1.0 || stripe >= 4.0)
        shown = light;
    else if (stripe >= 2.0 && stripe < 3.0)
        shown = srgbEncode(light);
    FragColor = vec4(vec3(shown), 1.0);
}
