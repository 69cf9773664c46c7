#version 330 core
#include "lib/drawing.glsl"

in vec2 TexCoords;

out vec4 FragColor;

void main()
{
    vec2 place = TexCoords * 8.0;
    vec3 color = mix(vec3(0.16, 0.22, 0.30), vec3(0.86, 0.80, 0.68), chessboard(place));
    // Lines between the fields, with edges that are about a pixel soft at any distance.
    vec2 off = abs(fract(place + 0.5) - 0.5);
    float soft = 0.008 / gl_FragCoord.w;
    float grid = 1.0 - smoothstep(0.5 * soft, 1.5 * soft, min(off.x, off.y));
    color = mix(color, vec3(0.95, 0.55, 0.20), grid);

    // The farther fog, the more of the air between.
    float fog = (1.0 / gl_FragCoord.w - 2.1) / 1.8;
    FragColor = vec4(mix(color, vec3(0.55, 0.65, 0.75), 0.6 * fog), 1.0);
}
