#version 330 core
in float alpha;

out vec4 FragColor;

void main()
{
    if (alpha < 0.1) {
        discard;
    }
    FragColor = vec4(vec3(0.2, 0.5, 0.2), alpha);
}
