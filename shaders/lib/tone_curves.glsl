// Light without an upper end on a display: two fits of the film industry's ACES, and OKLab.

// K. Narkowicz's fit, each channel by itself.
vec3 filmic(vec3 light)
{
    return light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14);
}

// S. Hill's fit: into a wider space of colours, the curve there, and back.
const mat3 WIDER = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
const mat3 BACK = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);

vec3 filmicWide(vec3 light)
{
    vec3 wide = WIDER * light;
    vec3 curve = (wide * (wide + 0.0245786) - 0.000090537)
               / (wide * (0.983729 * wide + 0.4329510) + 0.238081);
    return BACK * curve;
}

// B. Ottosson's OKLab of linear sRGB: lightness, and two coordinates whose angle is the hue.
const mat3 TO_CONES = mat3(
    0.4122214708, 0.2119034982, 0.0883024619,
    0.5363325363, 0.6806995451, 0.2817188376,
    0.0514459929, 0.1073969566, 0.6299787005);
const mat3 FROM_CONES = mat3(
    4.0767416621, -1.2684380046, -0.0041960863,
    -3.3077115913, 2.6097574011, -0.7034186147,
    0.2309699292, -0.3413193965, 1.7076147010);
const mat3 TO_LAB = mat3(
    0.2104542553, 1.9779984951, 0.0259040371,
    0.7936177850, -2.4285922050, 0.7827717662,
    -0.0040720468, 0.4505937099, -0.8086757660);
const mat3 FROM_LAB = mat3(
    1.0, 1.0, 1.0,
    0.3963377774, -0.1055613458, -0.0894841775,
    0.2158037573, -0.0638541728, -1.2914855480);

vec3 toOklab(vec3 light)
{
    return TO_LAB * pow(max(TO_CONES * light, 1.0e-6), vec3(1.0 / 3.0));
}

vec3 fromOklab(vec3 lab)
{
    vec3 root = FROM_LAB * lab;
    return FROM_CONES * (root * root * root);
}

// The curve on lightness alone; towards white, colour fades and keeps its hue.
vec3 perceptual(vec3 light)
{
    vec3 lab = toOklab(light);
    float lightness = lab.x / sqrt(1.0 + lab.x * lab.x);
    float square = lightness * lightness;
    float fade = lightness / lab.x * (1.0 - square * square * square);
    return fromOklab(vec3(lightness, fade * lab.yz));
}
