#version 330 core

in vec3 Normal;

uniform vec3 lightColor;
uniform vec3 objectColor;   // the share of each kind of light that the object reflects

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec4 shaded;   // the same, darker where a ball turns away

void main()
{
    FragColor = vec4(lightColor * objectColor, 1.0);
    float facing = 0.5 + 0.5 * dot(normalize(Normal), vec3(-0.36, 0.48, 0.80));
    shaded = vec4(FragColor.rgb * (0.08 + 0.92 * facing * facing), 1.0);
}
