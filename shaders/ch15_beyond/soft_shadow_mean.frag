#version 330 core
uniform sampler2D map;

layout (location = 0) out vec2 moments;

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(map, 0) - 1;
    vec2 sum = vec2(0.0);
    for (int y = -6; y <= 6; ++y)
        for (int x = -6; x <= 6; ++x)
            sum += texelFetch(map, clamp(here + ivec2(x, y), ivec2(0), last), 0).rg;
    moments = sum / 169.0;
}
