// The cone of a spotlight with a soft edge.

struct Spot {
    vec3 position;
    vec3 direction;
    float cutOff;        // cosine of the inner cone's half angle
    float outerCutOff;   // cosine of the outer cone's half angle
};

// 1 on the inner cone, 0 on the outer one, linear in the cosine between and beyond.
float spotRatio(Spot light, vec3 fragPos)
{
    vec3 lightDir = normalize(light.position - fragPos);
    float theta = dot(lightDir, normalize(-light.direction));
    return (theta - light.outerCutOff) / (light.cutOff - light.outerCutOff);
}

// The share of the spotlight's light, 0 outside of the outer cone, 1 inside the inner one.
float spotIntensity(Spot light, vec3 fragPos)
{
    return clamp(spotRatio(light, fragPos), 0.0, 1.0);
}
