// Small strokes for pictures that people look at; no formula is judged through these.

// 1 on the curve where `value` is 0, `width` pixels wide, with soft edges.
float line(float value, float width)
{
    float pixels = abs(value) / max(fwidth(value), 1.0e-12);
    return 1.0 - smoothstep(0.5 * width - 0.5, 0.5 * width + 0.5, pixels);
}

// 0 and 1 on the fields of a chessboard of unit squares. mod divides, and divisions may err: of an
// even number it may be 2 as well as 0, but not of one and a half.
float chessboard(vec2 place)
{
    return mod(floor(place.x) + floor(place.y) + 0.5, 2.0) - 0.5;
}

// Numbers for a display as light, and light, 0 … 1, as the numbers a display expects.
vec3 decoded(vec3 shown)
{
    return pow(shown, vec3(2.2));
}

vec3 encoded(vec3 light)
{
    return pow(light, vec3(1.0 / 2.2));
}
