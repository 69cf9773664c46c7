#version 330 core
#include "lib/drawing.glsl"

#define POINTS 64
#define SLICES 6
#define SAMPLED 0
#define HORIZONS 1

in vec2 place;                // seen from straight above

uniform sampler2D landscape;  // colours, and heights as alpha
uniform vec3 points[POINTS];  // in a ball of radius 1
uniform vec2 slices[SLICES];  // directions, evenly over half a turn
uniform float radius;
uniform int steps;            // to either side of a slice
uniform int way;

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float sky;    // the share of it that is seen

const float QUARTER = 1.57079632679;

float heightAt(vec2 at)
{
    return textureLod(landscape, at, 0.0).a;
}

// The share of points above the surface that lie in nothing.
float sampled(vec3 here, vec3 normal)
{
    float open = 0.0;
    for (int k = 0; k < POINTS; ++k) {
        vec3 off = dot(points[k], normal) < 0.0 ? -points[k] : points[k];
        vec3 at = here + radius * off;
        if (heightAt(at.xy) <= at.z)
            open += 1.0;
    }
    return open / float(POINTS);
}

// The light between the view and a horizon, by the cosine to the normal (Jimenez et al. 2016).
float arc(float horizon, float lean)
{
    return 0.25 * (cos(lean) - cos(2.0 * horizon - lean) + 2.0 * horizon * sin(lean));
}

// How far up the highest thing on one side is, as an angle from straight up.
float horizonOf(vec3 here, vec2 along)
{
    float upward = -1.0;
    for (int k = 1; k <= steps; ++k) {
        vec2 off = radius * float(k) / float(steps) * along;
        float rise = heightAt(here.xy + off) - here.z;
        upward = max(upward, rise / sqrt(dot(off, off) + rise * rise));
    }
    return acos(min(upward, 1.0));    // which rounding may exceed
}

float horizons(vec3 here, vec3 normal)
{
    float sum = 0.0;
    for (int k = 0; k < SLICES; ++k) {
        vec2 along = slices[k];
        float inside = dot(normal.xy, along);
        float shown = sqrt(inside * inside + normal.z * normal.z);
        float lean = atan(inside / normal.z);  // of two arguments SwiftShader makes pi of -0.0
        // No farther than the surface itself.
        float right = min(horizonOf(here, along), lean + QUARTER);
        float left = max(-horizonOf(here, -along), lean - QUARTER);
        sum += shown * (arc(right, lean) + arc(left, lean));
    }
    return sum / float(SLICES);
}

void main()
{
    vec2 off = vec2(0.002, 0.0);
    vec2 slope = vec2(heightAt(place + off) - heightAt(place - off),
                      heightAt(place + off.yx) - heightAt(place - off.yx)) / 0.004;
    vec3 normal = normalize(vec3(-slope, 1.0));
    vec3 here = vec3(place, heightAt(place));
    sky = way == HORIZONS ? horizons(here, normal) : sampled(here, normal);
    FragColor = vec4(encoded(textureLod(landscape, place, 0.0).rgb * sky), 1.0);
}
