#version 330 core
in vec3 Normal;
in vec3 Color;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec4 BrightColor;    // what would glow
layout (location = 2) out vec4 NormalColor;    // the normal, as a colour
layout (location = 3) out float Luminance;

void main()
{
    vec3 n = normalize(Normal);
    vec3 light = Color * (0.25 + 0.75 * max(dot(n, vec3(-0.36, 0.80, 0.48)), 0.0));
    Luminance = dot(light, vec3(0.2126, 0.7152, 0.0722));
    FragColor = vec4(sqrt(light), 1.0);
    BrightColor = vec4(Luminance > 0.4 ? light : vec3(0.0), 1.0);
    NormalColor = vec4(0.5 * n + 0.5, 1.0);
}
