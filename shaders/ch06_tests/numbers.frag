#version 330 core
#include "lib/digits.glsl"

in vec2 place;   // fields of the table from its lower left corner

uniform sampler2D values;   // a texel a field
uniform float group;        // columns that belong together
uniform float whole;        // the value that is drawn brightest

out vec4 FragColor;

void main()
{
    float value = texelFetch(values, ivec2(floor(place)), 0).r;
    vec3 color = mix(vec3(0.09, 0.13, 0.22), vec3(0.98, 0.86, 0.55), value / whole);
    vec3 ink = value < 0.5 * whole ? vec3(0.95) : vec3(0.08);
    vec2 field = fract(place);
    color = mix(color, ink, number(field, int(value + 0.5)));
    float seam = min(mod(place.x, group), group - mod(place.x, group));
    color = min(field.x, field.y) < 0.03 || seam < 0.06 ? vec3(0.5) : color;
    FragColor = vec4(color, 1.0);
}
