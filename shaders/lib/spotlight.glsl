// A spotlight with a soft edge, shared by the case and its picture.

struct Light {
    vec3 position;
    vec3 direction;
    float cutOff;        // cosine of the inner cone's half angle
    float outerCutOff;   // cosine of the outer cone's half angle
};

// 1 on the inner cone, 0 on the outer one, linear in the cosine between and beyond.
float spotRatio(Light light, vec3 fragPos)
{
    vec3 lightDir = normalize(light.position - fragPos);
    float theta = dot(lightDir, normalize(-light.direction));
    return (theta - light.outerCutOff) / (light.cutOff - light.outerCutOff);
}
