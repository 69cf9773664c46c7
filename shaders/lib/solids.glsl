// Distances to solids, below 0 inside; nowhere steeper than 1, so that a step as long hits nothing.

float toSphere(vec3 place, float radius)
{
    return length(place) - radius;
}

float toTorus(vec3 place, float radius, float tube)
{
    return length(vec2(length(place.xz) - radius, place.y)) - tube;
}

float toBox(vec3 place, vec3 halves, float rounding)
{
    vec3 off = abs(place) - halves + rounding;
    return length(max(off, 0.0)) + min(max(off.x, max(off.y, off.z)), 0.0) - rounding;
}

// The smaller of two, blended where they differ by less than `width`.
float melted(float one, float other, float width)
{
    float near = max(width - abs(one - other), 0.0) / width;
    return min(one, other) - 0.25 * width * (near * near);
}

// A drop above a ring, a ball and a block on a floor.
float toScene(vec3 place)
{
    float ring = toTorus(place - vec3(0.0, 0.24, 0.0), 0.85, 0.24);
    float drop = melted(ring, toSphere(place - vec3(0.0, 0.72, 0.0), 0.52), 0.5);
    float ball = toSphere(place - vec3(-1.75, 0.5, 0.3), 0.5);
    float block = toBox(place - vec3(1.75, 0.55, -0.1), vec3(0.45, 0.55, 0.45), 0.12);
    return min(place.y, min(drop, min(ball, block)));
}
