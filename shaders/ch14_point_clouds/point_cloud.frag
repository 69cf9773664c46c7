#version 330 core
in float warmth;

out vec4 FragColor;

void main()
{
    // A square of pixels becomes a disc: bright in its middle, and no light outside of the circle.
    vec2 off = gl_PointCoord - 0.5;
    float light = max(1.0 - 4.0 * dot(off, off), 0.0);
    vec3 star = mix(vec3(0.20, 0.36, 0.85), vec3(1.0, 0.70, 0.35), warmth);
    FragColor = vec4(light * star, 1.0);
}
