#version 330 core
in vec2 place;   // 0…4 across: a panel for each unit, and one for all

uniform sampler2D BaseMap;
uniform sampler2D ReflectMap;
uniform sampler2D RefractMap;
uniform float reflectance;

out vec4 FragColor;

void main()
{
    vec2 at = fract(place);
    vec3 base = texture(BaseMap, at).rgb;
    vec3 reflected = texture(ReflectMap, at).rgb;
    vec3 refracted = texture(RefractMap, at).rgb;
    vec3 color = 0.5 * base + 0.5 * mix(refracted, reflected, reflectance);
    int panel = int(place.x);
    if (panel == 0)
        color = base;
    else if (panel == 1)
        color = reflected;
    else if (panel == 2)
        color = refracted;
    vec2 edge = abs(at - 0.5);
    FragColor = vec4(color * step(max(edge.x, edge.y), 0.485), 1.0);
}
