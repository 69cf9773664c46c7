#version 330 core
layout (location = 0) in vec3 aPos;   // in device coordinates already

uniform vec4 viewport;     // x, y, width, height
uniform vec2 depthRange;   // depths of the near and the far plane

out vec3 Ndc;
out vec3 Window;   // what the hardware makes of Ndc after this stage

void main()
{
    Ndc = aPos;
    vec2 half_ = 0.5 * viewport.zw;
    Window.xy = half_ * Ndc.xy + (viewport.xy + half_);
    Window.z = 0.5 * (depthRange.y - depthRange.x) * Ndc.z + 0.5 * (depthRange.x + depthRange.y);
    gl_Position = vec4(aPos, 1.0);
}
