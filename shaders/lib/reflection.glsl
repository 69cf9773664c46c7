// What a surface reflects of a lamp's light, by where the lamp and the viewer are. All directions
// are of unit length and point away from the surface.

// Lambert's cosine: how many rays meet a patch of a matte surface.
float diffuseFactor(vec3 normal, vec3 lightDir)
{
    return max(dot(normal, lightDir), 0.0);
}

// The gate: a face turned away from the lamp gets no light that it could mirror.
bool facesLamp(vec3 normal, vec3 lightDir)
{
    return dot(normal, lightDir) > 0.0;
}

// pow of a negative number, and of 0 to 0, is undefined in GLSL, so a lobe ends at 0.
float cosineLobe(float cosine, float shininess)
{
    return cosine > 0.0 ? pow(cosine, shininess) : 0.0;
}

// Phong: how near the viewer is to the mirrored ray.
float phongLobe(vec3 normal, vec3 lightDir, vec3 viewDir, float shininess)
{
    vec3 reflectDir = reflect(-lightDir, normal);
    return facesLamp(normal, lightDir) ? cosineLobe(dot(viewDir, reflectDir), shininess) : 0.0;
}

// Blinn: how near the normal is to the halfway vector between lamp and viewer.
float blinnLobe(vec3 normal, vec3 lightDir, vec3 viewDir, float shininess)
{
    vec3 halfwayDir = normalize(lightDir + viewDir);
    return facesLamp(normal, lightDir) ? cosineLobe(dot(normal, halfwayDir), shininess) : 0.0;
}
