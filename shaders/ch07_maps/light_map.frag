#version 330 core
in vec2 TexCoords;
in vec2 LightCoords;

uniform sampler2D diffuseMap;
uniform sampler2D lightMap;
uniform vec2 shown;            // how much of the texture, and of the light, is seen

out vec4 FragColor;

void main()
{
    vec3 color = mix(vec3(1.0), texture(diffuseMap, TexCoords).rgb, shown.x);
    vec3 light = mix(vec3(1.0), texture(lightMap, LightCoords).rgb, shown.y);
    FragColor = vec4(color * light, 1.0);
}
