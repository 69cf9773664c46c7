// The mean of the four texels around a place, as GL_LINEAR has it, of a texture that is filtered by GL_NEAREST.
// A GPU keeps GL_LINEAR's weights to 8 bits: a slope that is taken over a texel or less then has steps.
vec4 filtered(sampler2D image, vec2 at)
{
    vec2 size = vec2(textureSize(image, 0));
    vec2 place = at * size - 0.5;
    vec2 low = (floor(place) + 0.5) / size;
    vec2 high = (floor(place) + 1.5) / size;
    vec2 part = place - floor(place);
    vec4 lower = mix(textureLod(image, low, 0.0), textureLod(image, vec2(high.x, low.y), 0.0), part.x);
    vec4 upper = mix(textureLod(image, vec2(low.x, high.y), 0.0), textureLod(image, high, 0.0), part.x);
    return mix(lower, upper, part.y);
}
