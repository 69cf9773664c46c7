#version 330 core
in vec2 TexCoords;

uniform sampler2D scene;    // four times as wide and high: level 2 has one texel a pixel

out vec4 FragColor;

void main()
{
    // What is above 1, in its own colour, and rising from there: a step would flicker.
    vec3 light = textureLod(scene, TexCoords, 2.0).rgb;
    float brightest = max(light.r, max(light.g, light.b));
    FragColor = vec4(light * (max(brightest - 1.0, 0.0) / max(brightest, 0.0001)), 1.0);
}
