#version 330 core
uniform sampler2D image;

out vec4 FragColor;

void main()
{
    FragColor = texelFetch(image, ivec2(gl_FragCoord.xy), 0);
}
