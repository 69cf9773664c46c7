// A field of a truth table: green with a tick where something passed, red with a cross where not.

float toSegment(vec2 place, vec2 from, vec2 to)
{
    vec2 segment = to - from;
    float t = clamp(dot(place - from, segment) / dot(segment, segment), 0.0, 1.0);
    return length(place - from - t * segment);
}

// `place` runs from −1 to 1 over the field, `passed` is 0 or 1.
vec3 verdictField(vec2 place, float passed)
{
    float stroke;
    vec3 color;
    if (passed > 0.5) {
        color = vec3(0.16, 0.55, 0.34);
        stroke = min(toSegment(place, vec2(-0.42, 0.02), vec2(-0.12, -0.32)),
                     toSegment(place, vec2(-0.12, -0.32), vec2(0.42, 0.36)));
    } else {
        color = vec3(0.62, 0.20, 0.20);
        stroke = min(toSegment(place, vec2(-0.32, -0.32), vec2(0.32, 0.32)),
                     toSegment(place, vec2(-0.32, 0.32), vec2(0.32, -0.32)));
    }
    color = mix(color, vec3(0.97), 1.0 - smoothstep(0.07, 0.13, stroke));
    float border = max(abs(place.x), abs(place.y));
    return mix(color, vec3(0.08, 0.09, 0.11), smoothstep(0.84, 0.90, border));
}
