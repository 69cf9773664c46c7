#version 330 core
in vec3 ourColor;
in vec2 TexCoord;

out vec4 FragColor;
out vec3 share;   // of each corner in this pixel, as it was interpolated

void main()
{
    // Fields of an eighth in the texture's own coordinates, lighter and darker by turns. mod divides,
    // and divisions may err: of 2.0 it may be 2.0 as well as 0.0, but 2.5 is no borderline.
    vec2 field = floor(8.0 * TexCoord);
    float shade = mod(field.x + field.y + 0.5, 2.0) < 1.0 ? 1.0 : 0.75;
    FragColor = vec4(shade * ourColor, 1.0);
    share = ourColor;
}
