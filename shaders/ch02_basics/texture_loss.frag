#version 330 core
// What compression lost, amplified, on grey.
in vec2 TexCoords;

uniform sampler2D image;
uniform sampler2D original;

out vec4 FragColor;

void main()
{
    vec3 lost = texture(image, TexCoords).rgb - texture(original, TexCoords).rgb;
    FragColor = vec4(0.5 + 8.0 * lost, 1.0);
}
