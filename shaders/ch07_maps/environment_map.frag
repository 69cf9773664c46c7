#version 330 core
in vec3 FragPos;
in vec3 Normal;

uniform samplerCube sky;
uniform vec3 cameraPos;
uniform float ratio;           // of the refractive indices, outside over inside
uniform float base;            // how much is mirrored in the middle: 1 of a mirror

out vec4 FragColor;
out vec3 mirrored;             // where the two rays go
out vec3 bent;
out float share;               // how much is mirrored here

void main()
{
    vec3 ray = normalize(FragPos - cameraPos);
    vec3 normal = normalize(Normal);
    mirrored = reflect(ray, normal);
    bent = refract(ray, normal, ratio);
    float grazing = 1.0 - max(dot(normal, normalize(cameraPos - FragPos)), 0.0);
    float grazing2 = grazing * grazing;
    share = base + (1.0 - base) * (grazing2 * grazing2 * grazing);
    FragColor = mix(textureLod(sky, bent, 0.0), textureLod(sky, mirrored, 0.0), share);
}
