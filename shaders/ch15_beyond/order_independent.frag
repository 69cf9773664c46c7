#version 330 core
#include "lib/drawing.glsl"

#define LAYERS 6
#define BY_NUMBER 0
#define SORTED 1
#define WEIGHTED 2

in vec2 TexCoords;

uniform sampler2D colors;   // the layers, three beside each other and two above
uniform sampler2D depths;
uniform sampler2D lights;   // their weighted sum, and the share of the wall that is left
uniform sampler2D weights;
uniform int way;
uniform int order[LAYERS];  // of the list

out vec4 FragColor;

vec3 wall(vec2 place)
{
    return mix(vec3(0.78, 0.72, 0.60), vec3(0.92, 0.88, 0.80), chessboard(6.0 * place));
}

void main()
{
    ivec2 size = textureSize(lights, 0);
    ivec2 at = ivec2(TexCoords * vec2(size));
    vec3 behind = wall(TexCoords);
    vec3 seen = behind;
    if (way == WEIGHTED) {
        vec4 light = texelFetch(lights, at, 0);
        vec3 mean = light.rgb / max(texelFetch(weights, at, 0).r, 1.0e-6);
        seen = mix(mean, behind, light.a);
    } else {
        vec4 color[LAYERS];
        float depth[LAYERS];
        for (int k = 0; k < LAYERS; ++k) {
            ivec2 texel = at + size * ivec2(order[k] % 3, order[k] / 3);
            color[k] = texelFetch(colors, texel, 0);
            depth[k] = texelFetch(depths, texel, 0).r;
        }
        // The list is in any order: the farthest first, by exchanging neighbours.
        for (int last = LAYERS - 1; way == SORTED && last > 0; --last)
            for (int k = 0; k < last; ++k)
                if (depth[k] < depth[k + 1]) {
                    vec4 nearer = color[k];
                    color[k] = color[k + 1];
                    color[k + 1] = nearer;
                    float less = depth[k];
                    depth[k] = depth[k + 1];
                    depth[k + 1] = less;
                }
        for (int k = 0; k < LAYERS; ++k)
            seen = mix(seen, color[k].rgb, color[k].a);
    }
    FragColor = vec4(encoded(seen), 1.0);
}
