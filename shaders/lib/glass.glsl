// Petals of glass before a wall: each is a flat disc that leans, so that none is wholly in front.

struct Petal {
    vec2 centre;
    vec2 lean;      // how its depth grows, to the right and upward
    vec3 color;
};

const float RADIUS = 0.52;

// How much of what is behind it a petal hides: less inside than on its rim; 0 outside.
float cover(Petal petal, vec2 place, float pixel)
{
    float away = distance(place, petal.centre);
    float inside = clamp((RADIUS - away) / pixel + 0.5, 0.0, 1.0);
    return inside * mix(0.5, 0.85, smoothstep(RADIUS - 0.09, RADIUS - 0.02, away));
}

float depthOf(Petal petal, vec2 place)
{
    return 0.5 + dot(petal.lean, place);
}
