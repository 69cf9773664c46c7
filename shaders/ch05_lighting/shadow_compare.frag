#version 330 core
#include "lib/shadow.glsl"

in vec3 Normal;
in vec4 FragPosLightSpace;

uniform sampler2DShadow shadowMap;   // compares by itself: 1 where the depth asked for is no deeper
uniform vec3 lightPos;               // a sun in this direction
uniform float leastBias;
uniform float mostBias;

out float shadow;

void main()
{
    vec3 at = shadowCoordinates(FragPosLightSpace);
    float bias = slopeBias(normalize(Normal), normalize(lightPos), leastBias, mostBias);
    float bright = texture(shadowMap, vec3(at.xy, at.z - bias));
    shadow = at.z > 1.0 ? 0.0 : 1.0 - bright;
}
