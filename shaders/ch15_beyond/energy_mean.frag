#version 330 core
uniform sampler2D table;

out float mean;    // 2 ∫ E(μ) μ dμ, of the pixel's row

void main()
{
    int count = textureSize(table, 0).x;
    float sum = 0.0;
    for (int k = 0; k < count; ++k)
        sum += texelFetch(table, ivec2(k, gl_FragCoord.y), 0).r * (float(k) + 0.5);
    mean = 2.0 * sum / float(count * count);
}
