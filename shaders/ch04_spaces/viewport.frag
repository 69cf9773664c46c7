#version 330 core

in vec3 Ndc;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec3 landed;   // where the hardware put this fragment

void main()
{
    vec2 place = 0.5 * Ndc.xy + 0.5;
    vec3 color = vec3(0.25 + 0.5 * place.x, 0.55 - 0.2 * place.x, 0.45 + 0.3 * place.y);

    vec2 field = abs(fract(4.0 * Ndc.xy + 0.5) - 0.5);   // 0 on the lines, every quarter
    float grid = min(field.x, field.y);
    color *= grid < 0.03 ? 0.75 : 1.0;
    color *= min(abs(Ndc.x), abs(Ndc.y)) < 0.012 ? 0.4 : 1.0;

    vec2 off = Ndc.xy - vec2(0.5, -0.5);
    color = dot(off, off) < 0.0064 ? vec3(1.0, 0.85, 0.2) : color;
    FragColor = vec4(color, 1.0);
    landed = gl_FragCoord.xyz;
}
