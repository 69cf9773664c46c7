#version 330 core
in vec2 at;   // 0 … 1 over the panel

uniform sampler2D scene;

out vec4 FragColor;

void main()
{
    vec2 edge = min(at, 1.0 - at);
    vec3 color = texture(scene, at).rgb;
    FragColor = vec4(min(edge.x, edge.y) < 0.01 ? vec3(0.97) : color, 1.0);
}
