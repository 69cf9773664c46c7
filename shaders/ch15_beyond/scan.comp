#version 430 core
layout (local_size_x = 256) in;

layout (std430) readonly buffer Numbers { uint numbers[]; };
layout (std430) writeonly buffer Sums { uint sums[]; };

shared uint partial[2][256];

// Each adds what is 1, 2, 4 … to its left (Hillis & Steele 1986).
void main()
{
    uint own = gl_LocalInvocationID.x;
    partial[0][own] = numbers[own];
    uint from = 0u;
    for (uint off = 1u; off < 256u; off *= 2u) {
        barrier();
        uint sum = partial[from][own];
        if (own >= off)
            sum += partial[from][own - off];
        partial[1u - from][own] = sum;
        from = 1u - from;
    }
    sums[own] = partial[from][own];
}
