#version 330 core
// Everything in main, no includes, other names, another order.
out vec4 FragColor;
out float specular;

in vec3 FragPos;
in vec3 Normal;

uniform bool blinn;
uniform float shininess;
uniform vec3 viewPos;
uniform vec3 lightPos;

void main()
{
    vec3 toLight = lightPos - FragPos;
    vec3 toEye = viewPos - FragPos;
    vec3 N = Normal / length(Normal);
    vec3 L = toLight / length(toLight);
    vec3 V = toEye / length(toEye);

    float angle = blinn ? dot(normalize(V + L), N) : dot(V, reflect(-L, N));
    specular = 0.0;
    if (angle > 0.0 && dot(L, N) > 0.0)
        specular = pow(angle, shininess);

    float lambert = clamp(dot(L, N), 0.0, 1.0);
    vec3 base = vec3(0.10, 0.14, 0.20);
    if (FragPos.y > 0.001)
        base = vec3(0.55, 0.16, 0.12);
    vec3 sum = base * 0.06;
    sum += base * lambert * 0.9;
    sum += 0.55 * specular;
    FragColor.rgb = pow(clamp(sum, 1.0e-6, 1.0), vec3(1.0 / 2.2));
    FragColor.a = 1.0;
}
