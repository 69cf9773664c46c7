#version 330 core
uniform sampler2D image;
uniform int level;

out vec4 FragColor;
out vec2 extent;    // of the level, in texels

void main()
{
    ivec2 size = textureSize(image, level);
    FragColor = texelFetch(image, ivec2(gl_FragCoord.xy), level);
    extent = vec2(size);
}
