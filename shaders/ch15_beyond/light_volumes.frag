#version 330 core
in vec2 TexCoords;

uniform sampler2D lamps;
uniform sampler2D gNormal;
uniform sampler2D gAlbedoSpec;
uniform vec3 dusk;

out vec4 FragColor;

void main()
{
    vec3 ambient = dusk * (0.75 + 0.25 * texture(gNormal, TexCoords).y);
    vec3 light = texture(lamps, TexCoords).rgb + ambient * texture(gAlbedoSpec, TexCoords).rgb;
    FragColor = vec4(light, 1.0);
}
