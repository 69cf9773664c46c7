#version 330 core
in vec2 place;   // fields of the table from its lower left corner

uniform sampler2D values;   // a texel a field

out vec4 FragColor;

void main()
{
    vec4 value = texelFetch(values, ivec2(floor(place)), 0);
    vec2 field = fract(place);
    // The upper left half is the colour, the lower right one the alpha, as grey.
    vec3 color = field.y - field.x > 0.02 ? value.rgb : vec3(value.a);
    color = clamp(color, 0.0, 1.0);
    color = min(field.x, field.y) < 0.06 ? vec3(0.25) : color;
    FragColor = vec4(color, 1.0);
}
