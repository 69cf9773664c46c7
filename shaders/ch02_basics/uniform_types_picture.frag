#version 330 core
#include "lib/drawing.glsl"

struct Material {
    vec3 ambient;
    float shininess;
};

in vec2 place;   // 0…4 across, 0…2 up: eight instruments

uniform float f;
uniform int i;
uniform uint u;
uniform vec3 v3;
uniform float fv[4];
uniform vec2 pairs[2];
uniform Material material;
uniform mat2x3 m;

out vec4 FragColor;

vec3 instrument(int which, vec2 at)
{
    vec3 back = vec3(0.04, 0.05, 0.065), mark = vec3(0.75, 0.80, 0.85), warm = vec3(1.0, 0.55, 0.12);
    if (which == 0) {   // float: a needle over a half circle
        vec2 off = at + vec2(0.0, 0.35);
        float angle = atan(off.y, off.x) / 3.14159265, r = length(off);
        if (off.y > 0.0 && r > 0.55 && r < 0.85)
            return 1.0 - angle < f ? warm : back * 3.0;
        return back;
    }
    if (which == 1)     // int: so many dots
        return length(fract((at + 0.8) * 2.5) - 0.5) < 0.32 && max(abs(at.x), abs(at.y)) < 0.8
            && int((at.x + 0.8) * 2.5) + 4 * (3 - int((at.y + 0.8) * 2.5)) < i ? warm : back;
    if (which == 2) {   // uint: its lowest eight bits
        if (abs(at.x) > 0.8 || abs(at.y) > 0.3)
            return back;
        float x = (at.x + 0.8) * 5.0;
        float on = float((u >> uint(7 - int(x))) & 1u);
        return abs(fract(x) - 0.5) < 0.42 ? mix(back * 3.0, mark, on) : back;
    }
    if (which == 3)     // vec3: a colour
        return max(abs(at.x), abs(at.y)) < 0.6 ? v3 : back;
    if (which == 4) {   // float[4]: bars
        float x = (at.x + 0.8) * 2.5;
        bool bar = abs(at.x) < 0.8 && abs(fract(x) - 0.5) < 0.36 && at.y > -0.8;
        return bar && at.y < 1.6 * fv[int(min(x, 3.0))] - 0.8 ? vec3(0.2, 0.55, 0.9) : back;
    }
    if (which == 5) {   // vec2[2]: two places
        vec3 color = min(abs(at.x), abs(at.y)) < 0.006 ? mix(back, mark, 0.25) : back;
        color = length(at - pairs[0]) < 0.12 ? warm : color;
        return length(at - pairs[1]) < 0.12 ? vec3(0.2, 0.55, 0.9) : color;
    }
    if (which == 6) {   // struct: a ball of that material
        float r = length(at) / 0.7;
        vec3 n = vec3(at / 0.7, sqrt(max(1.0 - r * r, 0.0)));
        float lobe = pow(max(dot(n, normalize(vec3(-0.4, 0.5, 0.9))), 0.0), material.shininess);
        return r < 1.0 ? material.ambient * (0.25 + 0.75 * n.z) + 0.6 * lobe : back;
    }
    // mat2x3: its two columns, as three bars each
    float x = (at.x + 0.8) * 3.75;
    int k = int(clamp(x, 0.0, 5.0));
    bool bar = abs(at.x) < 0.8 && abs(fract(x) - 0.5) < 0.36 && at.y > -0.8;
    vec3 hue = k < 3 ? warm : vec3(0.25, 0.75, 0.45);
    return bar && at.y < 1.6 * m[k / 3][k % 3] - 0.8 ? hue : back;
}

void main()
{
    vec2 at = fract(place) * 2.0 - 1.0;
    vec3 color = instrument(int(place.x) + 4 * (1 - int(place.y)), at);
    color *= step(max(abs(at.x), abs(at.y)), 0.96);
    FragColor = vec4(encoded(min(color, 1.0)), 1.0);
}
