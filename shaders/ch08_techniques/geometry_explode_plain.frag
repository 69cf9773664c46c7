#version 330 core
in VS_OUT {
    vec3 world;
    vec3 color;
} fs_in;

out vec4 FragColor;

void main()
{
    FragColor = vec4(fs_in.color + 0.25 * fs_in.world, 1.0);
}
