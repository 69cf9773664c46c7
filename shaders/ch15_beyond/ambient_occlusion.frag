#version 330 core
#include "lib/drawing.glsl"
#include "lib/filtered.glsl"

#define POINTS 64
#define SLICES 6
#define SAMPLED 0
#define HORIZONS 1

in vec2 place;                // seen from straight above

uniform sampler2D landscape;  // colours, and heights as alpha; filtered here
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
    return filtered(landscape, at).a;
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

// The light between the view and a horizon that rises so steeply, by the cosine to a normal whose parts
// towards the horizon and the view these are (Jimenez et al. 2016): with the angle h from the view
// (upward sin² h + toward (h - sin h cos h)) / 2.
float arc(float slope, float toward, float upward)
{
    float sine = inversesqrt(1.0 + slope * slope);
    return 0.5 * (sine * sine * upward + (QUARTER - atan(slope) - slope * sine * sine) * toward);
}

// How steeply the highest thing on one side rises, no less than the surface itself.
float steepest(vec3 here, vec2 along, float slope)
{
    for (int k = 1; k <= steps; ++k) {
        float far = radius * float(k) / float(steps);
        slope = max(slope, (heightAt(here.xy + far * along) - here.z) / far);
    }
    return slope;
}

float horizons(vec3 here, vec3 normal)
{
    float sum = 0.0;
    for (int k = 0; k < SLICES; ++k) {
        vec2 along = slices[k];
        float toward = dot(normal.xy, along);
        float falls = toward / normal.z;
        sum += arc(steepest(here, along, -falls), toward, normal.z);
        sum += arc(steepest(here, -along, falls), -toward, normal.z);
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
    FragColor = vec4(encoded(filtered(landscape, place).rgb * sky), 1.0);
}
