#version 330 core
in vec2 TexCoords;

uniform sampler2D lit;
uniform sampler2D bright;
uniform sampler2D normals;
uniform sampler2D luminance;

out vec4 FragColor;

void main()
{
    vec2 tile = 2.0 * TexCoords;
    vec2 st = fract(tile);
    vec3 below = tile.x < 1.0 ? texture(normals, st).rgb : texture(luminance, st).rrr;
    vec3 above = tile.x < 1.0 ? texture(lit, st).rgb : texture(bright, st).rgb;
    FragColor = vec4(tile.y < 1.0 ? below : above, 1.0);
}
