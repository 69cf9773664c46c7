#version 330 core
#include "lib/shadow.glsl"

#define CASCADES 3

in vec3 FragPos;
in vec3 Normal;
in vec3 Color;

uniform sampler2DArray shadowMaps;
uniform mat4 lightSpaceMatrices[CASCADES];
uniform float splits[CASCADES];    // depths where the cascades end
uniform float biases[CASCADES];    // the least bias of each, as large as its texels ask for
uniform mat4 view;
uniform vec3 lightPos;             // a sun in this direction
uniform float tint;                // how much of a cascade's own colour is shown

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float cascade;
layout (location = 2) out float shadow;
layout (location = 3) out vec3 place;
layout (location = 4) out vec3 upright;
layout (location = 5) out float bias;

void main()
{
    vec3 normal = normalize(Normal);
    vec3 lightDir = normalize(lightPos);

    float depth = -(view * vec4(FragPos, 1.0)).z;
    int index = 0;
    for (int i = 0; i < CASCADES - 1; ++i)
        if (depth >= splits[i])
            index = i + 1;
    cascade = float(index);

    vec3 at = shadowCoordinates(lightSpaceMatrices[index] * vec4(FragPos, 1.0));
    bias = slopeBias(normal, lightDir, biases[index], 6.0 * biases[index]);
    shadow = shadowOf(at.z, texture(shadowMaps, vec3(at.xy, cascade)).r, bias);
    place = FragPos;
    upright = normal;

    vec3 own = vec3(0.9, 0.25, 0.2);
    if (index > 0)
        own = index > 1 ? vec3(0.2, 0.35, 0.9) : vec3(0.25, 0.75, 0.3);
    float light = 0.15 + (1.0 - shadow) * max(dot(normal, lightDir), 0.0);
    FragColor = vec4(light * mix(Color, own, tint), 1.0);
}
