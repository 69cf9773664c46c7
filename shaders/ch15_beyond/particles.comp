#version 430 core
layout (local_size_x = 64) in;

layout (std430) readonly buffer Places { vec2 places[]; };
layout (std430) buffer Speeds { vec2 speeds[]; };

uniform float time;

// All attract all; what one is pulled, the other is pulled back.
void main()
{
    uint own = gl_LocalInvocationID.x;
    vec2 pull = vec2(0.0);
    for (int k = 0; k < 64; ++k) {
        vec2 off = places[k] - places[own];
        float square = dot(off, off) + 0.04;
        pull += off / (square * sqrt(square));
    }
    speeds[own] += time * pull;
}
