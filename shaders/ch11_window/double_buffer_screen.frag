#version 330 core
uniform sampler2D front;   // what the screen shows while it refreshes

out vec4 FragColor;

void main()
{
    FragColor = texelFetch(front, ivec2(gl_FragCoord.xy), 0);
}
