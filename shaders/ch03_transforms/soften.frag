#version 330 core

uniform sampler2D scene;   // twice as wide and twice as high as what is drawn here

out vec4 FragColor;

void main()
{
    // A pixel's four texels, each read at its centre: edges become smooth.
    vec2 texel = 1.0 / vec2(textureSize(scene, 0));
    vec2 corner = 2.0 * gl_FragCoord.xy;
    FragColor = 0.25 * (texture(scene, (corner + vec2(-0.5, -0.5)) * texel)
                      + texture(scene, (corner + vec2(0.5, -0.5)) * texel)
                      + texture(scene, (corner + vec2(-0.5, 0.5)) * texel)
                      + texture(scene, (corner + vec2(0.5, 0.5)) * texel));
}
