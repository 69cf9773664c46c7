#version 330 core
in vec2 place;

uniform vec2 middle;

out vec4 FragColor;

void main()
{
    vec2 off = (place - middle) / 0.3;
    if (dot(off, off) > 1.0)
        discard;
    float light = 0.5 + 0.5 * dot(off, vec2(-0.5, 0.5));
    FragColor = vec4(light * vec3(1.0, 0.86, 0.32), 1.0);
}
