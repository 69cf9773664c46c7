#version 330 core
in vec3 fColor;
in vec3 fNormal;

out vec4 FragColor;

void main()
{
    float lamp = max(dot(normalize(fNormal), vec3(-0.36, 0.80, 0.48)), 0.0);
    FragColor = vec4(sqrt(fColor * (0.3 + 0.7 * lamp)), 1.0);
}
