#version 330 core
in vec2 TexCoords;

uniform sampler2D image;    // as a display shows it, not light; filtered linearly

out vec4 FragColor;

vec3 at(vec2 place)
{
    return textureLod(image, place, 0.0).rgb;
}

float luma(vec3 color)
{
    return dot(color, vec3(0.299, 0.587, 0.114));
}

// T. Lottes 2011: where there is an edge, the mean of some places along it.
void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(image, 0) - 1;
    vec3 middle = texelFetch(image, here, 0).rgb;
    float corner[4];
    for (int k = 0; k < 4; ++k) {
        ivec2 off = ivec2(2 * (k % 2) - 1, 2 * (k / 2) - 1);
        corner[k] = luma(texelFetch(image, clamp(here + off, ivec2(0), last), 0).rgb);
    }
    float least = min(luma(middle), min(min(corner[0], corner[1]), min(corner[2], corner[3])));
    float most = max(luma(middle), max(max(corner[0], corner[1]), max(corner[2], corner[3])));
    vec3 color = middle;
    if (most - least >= max(0.05, 0.125 * most)) {
        // Across the way in which the corners grow.
        vec2 along = vec2(corner[0] + corner[1] - corner[2] - corner[3],
                          corner[1] + corner[3] - corner[0] - corner[2]);
        float sum = corner[0] + corner[1] + corner[2] + corner[3];
        float shorter = min(abs(along.x), abs(along.y)) + max(sum / 32.0, 0.0078125);
        along = clamp(along / shorter, -8.0, 8.0) / vec2(textureSize(image, 0));
        vec3 near = 0.5 * (at(TexCoords - along / 6.0) + at(TexCoords + along / 6.0));
        vec3 far = 0.25 * (at(TexCoords - 0.5 * along) + at(TexCoords + 0.5 * along)) + 0.5 * near;
        // The far ones may lie on something else.
        color = luma(far) < least || luma(far) > most ? near : far;
    }
    FragColor = vec4(color, 1.0);
}
