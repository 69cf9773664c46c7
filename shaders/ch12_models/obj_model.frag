#version 330 core
#include "lib/drawing.glsl"
#include "lib/reflection.glsl"

in vec3 FragPos;
in vec3 Normal;
in vec2 TexCoords;

uniform vec3 diffuse;      // the material's Kd
uniform float shininess;   // and its Ns
uniform vec3 lightDir;     // towards the light, of length 1
uniform vec3 viewPos;

out vec4 FragColor;

void main()
{
    vec3 normal = normalize(Normal);
    vec3 viewDir = normalize(viewPos - FragPos);
    float lambert = 0.22 + 0.78 * diffuseFactor(normal, lightDir);
    float gloss = 0.3 * blinnLobe(normal, lightDir, viewDir, shininess);

    // Courses of stone, twelve a unit of t.
    float joint = fract(12.0 * TexCoords.t) < 0.125 ? 0.8 : 1.0;
    FragColor = vec4(encoded(min(joint * lambert * diffuse + gloss, 1.0)), 1.0);
}
