// The two classic specular lobes. All directions are of unit length and point away from the
// surface.

// pow with a base of 0 or less is undefined in GLSL, so the lobe ends there.
float lobe(float cosine, float shininess)
{
    return cosine > 0.0 ? pow(cosine, shininess) : 0.0;
}

float phongLobe(vec3 normal, vec3 lightDir, vec3 viewDir, float shininess)
{
    vec3 reflectDir = reflect(-lightDir, normal);
    return lobe(dot(reflectDir, viewDir), shininess);
}

float blinnLobe(vec3 normal, vec3 lightDir, vec3 viewDir, float shininess)
{
    vec3 halfwayDir = normalize(lightDir + viewDir);
    return lobe(dot(normal, halfwayDir), shininess);
}
