#version 330 core
in vec2 place;   // −1 … 1 over the quad that carries the leaf

uniform float threshold;   // fragments below are thrown away

out vec4 FragColor;

void main()
{
    // Pointed at both ends, with a rib along the middle; alpha falls off over a soft edge.
    float t = 0.5 + 0.5 * place.y;
    float width = 2.4 * t * (1.0 - t);
    float alpha = clamp(8.0 * (width - abs(place.x)), 0.0, 1.0);
    if (alpha < threshold) {
        discard;
    }
    float rib = max(1.0 - 14.0 * abs(place.x), 0.0);
    vec3 color = mix(vec3(0.13, 0.36, 0.12), vec3(0.47, 0.68, 0.20), t);
    color = mix(vec3(0.90), mix(color, vec3(0.78, 0.85, 0.50), 0.7 * rib), alpha);
    FragColor = vec4(color, alpha);
}
