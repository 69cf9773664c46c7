#version 330 core
in vec2 place;              // about the sign's middle, −1 … 1

out vec4 FragColor;

float toSegment(vec2 at, vec2 from, vec2 to)
{
    vec2 along = to - from;
    return distance(at, from + clamp(dot(at - from, along) / dot(along, along), 0.0, 1.0) * along);
}

// How bright bricks are: each row is shifted by half a brick, with mortar all around.
float bricks(vec2 at)
{
    vec2 brick = at * vec2(4.0, 8.0);
    brick.x += 0.5 * mod(floor(brick.y) + 0.5, 2.0);
    vec2 edge = 0.5 - abs(fract(brick) - 0.5);
    float inside = smoothstep(0.04, 0.12, edge.x) * smoothstep(0.08, 0.20, edge.y);
    return 0.25 + 0.75 * inside;
}

// A tube of gas: white-hot in its middle, its colour around, and a little light on the wall.
vec3 tube(float away, vec3 color, float wall)
{
    float core = 1.0 - smoothstep(0.020, 0.034, away);
    return color * (8.0 * core + 0.30 * wall * exp(-5.0 * away));
}

void main()
{
    float wall = bricks(place);
    float bolt = min(toSegment(place, vec2(0.16, 0.46), vec2(-0.20, -0.04)),
                     min(toSegment(place, vec2(-0.20, -0.04), vec2(0.20, 0.06)),
                         toSegment(place, vec2(0.20, 0.06), vec2(-0.14, -0.46))));
    vec3 light = vec3(0.010, 0.012, 0.020) * wall;
    light += tube(abs(length(place) - 0.70), vec3(1.0, 0.08, 0.30), wall);
    light += tube(bolt, vec3(0.10, 0.55, 1.0), wall);
    FragColor = vec4(light, 1.0);
}
