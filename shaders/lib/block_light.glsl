// A block whose members need padding: bytes 0, 16, 32 (three elements 16 apart), 80 and 96.
layout (std140) uniform Lights
{
    float ambient;
    vec3 towards;      // the sun; a unit vector
    float gains[3];    // of red, green and blue
    vec3 sky;
    mat2 tint;         // from up and down to warm and cold
} lights;

vec3 lit(vec3 color, vec3 normal)
{
    vec3 n = normalize(normal);
    float sun = max(dot(n, lights.towards), 0.0);
    vec2 mood = lights.tint * vec2(max(n.y, 0.0), max(-n.y, 0.0));
    vec3 gain = vec3(lights.gains[0], lights.gains[1], lights.gains[2]);
    return sqrt(color * (lights.ambient * lights.sky + gain * sun) + vec3(mood.x, 0.0, mood.y));
}
