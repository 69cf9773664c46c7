#version 430 core
layout (local_size_x = 64) in;

#define SIZE 128

layout (rg32f) readonly uniform image2D before;
layout (rg32f) writeonly uniform image2D after;

uniform bool upright;         // lines are columns
uniform vec2 roots[SIZE / 2];  // of unity, clockwise

shared vec2 numbers[2][SIZE];

ivec2 place(int k)
{
    int line = int(gl_WorkGroupID.x);
    return upright ? ivec2(line, k) : ivec2(k, line);
}

// One line for each work group, in seven steps (Stockham): half the sums stay apart, half as far.
void main()
{
    int own = int(gl_LocalInvocationID.x);
    for (int k = own; k < SIZE; k += 64)
        numbers[0][k] = imageLoad(before, place(k)).rg;
    int from = 0;
    for (int width = 1; width < SIZE; width *= 2) {
        barrier();
        int low = own % width;
        int part = own / width;
        vec2 one = numbers[from][own];
        vec2 other = numbers[from][own + SIZE / 2];
        vec2 root = roots[part * width];
        vec2 apart = one - other;
        numbers[1 - from][low + 2 * part * width] = one + other;
        numbers[1 - from][low + 2 * part * width + width] =
            vec2(apart.x * root.x - apart.y * root.y, apart.x * root.y + apart.y * root.x);
        from = 1 - from;
    }
    barrier();
    for (int k = own; k < SIZE; k += 64)
        imageStore(after, place(k), vec4(numbers[from][k], 0.0, 0.0));
}
