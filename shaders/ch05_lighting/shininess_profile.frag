#version 330 core
#include "lib/reflection.glsl"

in float slope;   // tangent of the angle between the viewer and the mirrored ray
in float level;   // 0 on the base line, 1 at the lobe's peak

uniform float shininess;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float lobe;

void main()
{
    // The light comes down along the normal, and that is where it is mirrored to.
    vec3 normal = vec3(0.0, 1.0, 0.0);
    lobe = phongLobe(normal, normal, normalize(vec3(slope, 1.0, 0.0)), shininess);

    vec3 color = vec3(0.012, 0.014, 0.02);
    if (level < 0.0)
        color = vec3(0.25);
    else if (level < lobe)
        color = lobe < 0.5 ? vec3(0.06, 0.13, 0.26) : vec3(0.90, 0.42, 0.06);
    FragColor = vec4(color, 1.0);
}
