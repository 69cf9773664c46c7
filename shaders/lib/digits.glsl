// Whole numbers written into pictures of tables, in figures of 3 × 5 dots; nothing is judged by them.

// One figure's dots, from the lower left to the upper right.
const int FIGURES[10] = int[10](31599, 9879, 31183, 31207, 23524, 29671, 29679, 30994, 31727, 31719);

// 1 on the dots of a figure that fills `place` from (0, 0) to (1, 1).
float figure(vec2 place, int digit)
{
    ivec2 dot_ = ivec2(floor(place * vec2(3.0, 5.0)));
    bool inside = all(greaterThanEqual(dot_, ivec2(0))) && all(lessThan(dot_, ivec2(3, 5)));
    return inside ? float((FIGURES[digit] >> (3 * dot_.y + dot_.x)) & 1) : 0.0;
}

// 1 on the dots of a number of up to three figures in the middle of a field (0, 0) to (1, 1).
float number(vec2 place, int n)
{
    int count = n > 99 ? 3 : (n > 9 ? 2 : 1);
    vec2 size = vec2(0.18, 0.42);
    float pitch = 0.25;
    float left = 0.5 - 0.5 * (pitch * float(count - 1) + size.x);
    float ink = 0.0;
    for (int i = 0; i < count; ++i) {
        int power = i == count - 1 ? 1 : (i == count - 2 ? 10 : 100);
        vec2 corner = vec2(left + pitch * float(i), 0.5 - 0.5 * size.y);
        ink = max(ink, figure((place - corner) / size, (n / power) % 10));
    }
    return ink;
}
