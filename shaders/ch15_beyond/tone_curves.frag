#version 330 core
#include "lib/tone_curves.glsl"
#include "lib/drawing.glsl"

in vec2 place;              // hue in turns, and stops of exposure

uniform int curve;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec3 light;    // before the curve
layout (location = 2) out vec3 lab;      // the same in OKLab
layout (location = 3) out vec3 again;    // and back
layout (location = 4) out vec3 curved;   // by the curve there, and back

void main()
{
    vec3 pure = clamp(abs(fract(place.x + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    light = exp2(place.y) * mix(vec3(1.0), pure, 0.9);
    lab = toOklab(light);
    again = fromOklab(lab);
    curved = perceptual(light);
    vec3 shown = curve == 0 ? light : curve == 1 ? filmic(light)
               : curve == 2 ? filmicWide(light) : curved;
    FragColor = vec4(encoded(clamp(shown, 0.0, 1.0)), 1.0);
}
