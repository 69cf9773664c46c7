#version 330 core
in vec2 place;              // −1 … 1

uniform sampler2D aperture;
uniform sampler2D spectrum;
uniform bool far;           // what is seen through the aperture, or the aperture itself

out vec4 FragColor;

// The light of one wavelength: the longer, the wider it is bent.
float light(float wavelength)
{
    ivec2 at = ivec2(floor(place * 56.0 / wavelength + 0.5)) & 127;
    vec2 wave = texelFetch(spectrum, at, 0).rg;
    return log(1.0 + 0.02 * dot(wave, wave)) / 9.0;
}

void main()
{
    vec3 color = vec3(texture(aperture, 0.5 * place + 0.5).r);
    if (far)
        color = vec3(light(1.2), light(1.0), light(0.84));
    FragColor = vec4(color, 1.0);
}
