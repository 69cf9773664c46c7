#version 330 core
in vec2 at;   // texels from the lower left corner, the same for all three

uniform sampler2D far_to_near;
uniform sampler2D near_to_far;
uniform sampler2D depth_written;
uniform float shown;   // which of them is the picture: 0, 1 or 2

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec4 sorted;
layout (location = 2) out vec4 reversed_;
layout (location = 3) out vec4 written;

void main()
{
    ivec2 texel = ivec2(at);
    sorted = texelFetch(far_to_near, texel, 0);
    reversed_ = texelFetch(near_to_far, texel, 0);
    written = texelFetch(depth_written, texel, 0);
    vec4 color = shown < 0.5 ? sorted : (shown < 1.5 ? reversed_ : written);
    vec2 border = min(at, vec2(textureSize(far_to_near, 0)) - at);
    FragColor = vec4(min(border.x, border.y) < 3.6 ? vec3(0.97) : color.rgb, 1.0);
}
