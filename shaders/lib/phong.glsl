// The two parts of a lamp's light that depend on where it comes from. All directions are of unit
// length and point away from the surface.

// Lambert's cosine: how many rays meet a patch of a matte surface.
float diffuseFactor(vec3 normal, vec3 lightDir)
{
    return max(dot(normal, lightDir), 0.0);
}

// Phong's lobe: how near the viewer is to the mirrored ray. pow needs a positive base.
float specularFactor(vec3 normal, vec3 lightDir, vec3 viewDir, float shininess)
{
    vec3 reflectDir = reflect(-lightDir, normal);
    float cosine = dot(viewDir, reflectDir);
    return cosine > 0.0 ? pow(cosine, shininess) : 0.0;
}
