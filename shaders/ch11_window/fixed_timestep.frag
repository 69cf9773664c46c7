#version 330 core
uniform float durations[64];   // how long each frame took, in seconds
uniform bool fixedSteps;
uniform float dt;              // the fixed step

layout (location = 0) out vec4 state;   // time, height, speed, and what is left over

void step_(inout float height, inout float speed, float seconds)
{
    speed -= 8.0 * seconds;
    height += speed * seconds;
    if (height < 0.0) {   // the floor gives three quarters of the speed back
        height = -height;
        speed = -0.75 * speed;
    }
}

void main()
{
    // One pixel a frame: pixel k is what the loop has come to after k + 1 frames.
    int frames = int(gl_FragCoord.x) + 1;
    float time = 0.0, height = 1.0, speed = 0.0, remainder = 0.0;
    for (int k = 0; k < frames; ++k) {
        time += durations[k];
        if (!fixedSteps) {
            step_(height, speed, durations[k]);
            continue;
        }
        remainder += durations[k];
        while (remainder >= dt) {
            step_(height, speed, dt);
            remainder -= dt;
        }
    }
    state = vec4(time, height, speed, remainder);
}
