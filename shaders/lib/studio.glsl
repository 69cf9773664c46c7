// One lamp over the left shoulder and a bright sky: light for scenes that show where things are.
#include "lib/drawing.glsl"

vec3 studio(vec3 color, vec3 normal)
{
    vec3 n = normalize(normal);
    float lamp = max(dot(n, vec3(-0.36, 0.80, 0.48)), 0.0);
    float sky = 0.5 + 0.5 * n.y;
    return encoded(min(color * (0.30 + 0.30 * sky + 0.55 * lamp), 1.0));
}
