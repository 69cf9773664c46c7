#version 330 core
#define BALLS 4

in vec2 place;              // on the floor, from straight above

uniform vec4 balls[BALLS];  // middles and radii

layout (location = 0) out vec2 moments;    // of the height of what the lamp sees: it, and its square

void main()
{
    float height = 0.0;
    for (int k = 0; k < BALLS; ++k)
        if (distance(place, balls[k].xz) < balls[k].w)
            height = max(height, balls[k].y);    // of its widest circle
    moments = vec2(height, height * height);
}
