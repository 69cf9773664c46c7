#version 330 core
in VS_OUT {
    vec3 normal;
} fs_in;

out vec4 FragColor;

void main()
{
    FragColor = vec4(0.5 * fs_in.normal + 0.5, 1.0);
}
