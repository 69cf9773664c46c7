#version 330 core
in vec2 TexCoords;

uniform sampler2D BaseMap;      // unit 0
uniform sampler2D ReflectMap;   // unit 1
uniform sampler2D RefractMap;   // unit 2
uniform float reflectance;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec3 base;
layout (location = 2) out vec3 reflected;
layout (location = 3) out vec3 refracted;

void main()
{
    base = texture(BaseMap, TexCoords).rgb;
    reflected = texture(ReflectMap, TexCoords).rgb;
    refracted = texture(RefractMap, TexCoords).rgb;
    FragColor = vec4(0.5 * base + 0.5 * mix(refracted, reflected, reflectance), 1.0);
}
