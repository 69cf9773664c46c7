#version 330 core
in vec2 at;   // texels of the scene from its lower left corner

uniform sampler2D resolved;
uniform sampler2DMS samples;
uniform float half_;   // the middle of the texels where one sample changes to all of them

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec4 mean;
layout (location = 2) out vec4 blitted;   // what glBlitFramebuffer made of the samples

void main()
{
    ivec2 texel = ivec2(floor(at));
    mean = vec4(0.0);
    for (int k = 0; k < 4; ++k) {
        mean += texelFetch(samples, texel, k);
    }
    mean *= 0.25;
    blitted = texelFetch(resolved, texel, 0);
    vec4 shown = at.x < half_ ? texelFetch(samples, texel, 0) : mean;
    FragColor = vec4(abs(at.x - half_) < 0.5 ? vec3(0.95, 0.55, 0.10) : shown.rgb, 1.0);
}
