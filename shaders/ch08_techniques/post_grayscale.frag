#version 330 core
in vec2 TexCoords;

uniform sampler2D screenTexture;

out vec4 FragColor;
out float average;     // every channel alike
out float luminance;   // as bright as the eye finds it

void main()
{
    vec3 color = texture(screenTexture, TexCoords).rgb;
    average = (color.r + color.g + color.b) / 3.0;
    luminance = dot(color, vec3(0.2126, 0.7152, 0.0722));
    float grey = TexCoords.x < 0.5 ? average : luminance;
    FragColor = vec4(vec3(grey), 1.0);
}
