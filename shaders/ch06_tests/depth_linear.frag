#version 330 core
in vec3 Color;
in float Distance;

uniform float near;
uniform float far;
uniform float linearly;   // which of the two the picture shows

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float linear;   // the distance again, out of the depth alone
layout (location = 2) out float travelled;

void main()
{
    float ndc = 2.0 * gl_FragCoord.z - 1.0;
    linear = 2.0 * near * far / (far + near - ndc * (far - near));
    float grey = linearly > 0.5 ? linear / far : gl_FragCoord.z;
    // A touch of the surface's own colour, for orientation.
    FragColor = vec4(mix(vec3(grey), Color, 0.12), 1.0);
    travelled = Distance;
}
