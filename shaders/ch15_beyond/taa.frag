#version 330 core
uniform sampler2D frame;
uniform sampler2D history;
uniform float share;        // of the new frame
uniform bool moving;        // the history may show what is there no more

out vec4 FragColor;

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(frame, 0) - 1;
    vec3 now = texelFetch(frame, here, 0).rgb;
    vec3 past = texelFetch(history, here, 0).rgb;
    vec3 least = now;
    vec3 most = now;
    for (int k = 0; k < 9; ++k) {
        ivec2 near = clamp(here + ivec2(k % 3 - 1, k / 3 - 1), ivec2(0), last);
        vec3 color = texelFetch(frame, near, 0).rgb;
        least = min(least, color);
        most = max(most, color);
    }
    if (moving)
        past = clamp(past, least, most);
    FragColor = vec4(mix(past, now, share), 1.0);
}
