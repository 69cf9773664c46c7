#version 330 core
layout (location = 0) in float frame;

uniform sampler2D run;   // one texel a frame: time, height, speed, what is left over
uniform bool ticks;      // when the frames were, instead of where the ball was

void main()
{
    vec2 place = texelFetch(run, ivec2(int(frame), 0), 0).xy;
    if (ticks)
        place.y = -0.075;
    gl_Position = vec4(2.0 * (place + vec2(0.03, 0.15)) / vec2(2.08, 1.25) - 1.0, 0.0, 1.0);
}
