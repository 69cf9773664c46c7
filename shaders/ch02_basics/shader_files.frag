#version 330 core
in vec2 field;   // column 0…48 from the left, row from the bottom

uniform sampler2D bytes;   // one texel a byte, one row a file; −1 past the file's end

layout (location = 0) out vec4 FragColor;
layout (location = 1) out float kind;

void main()
{
    float byte = texelFetch(bytes, ivec2(field), 0).r;

    kind = 1.0;                      // a character
    if (byte < 0.0)
        kind = 0.0;                  // nothing: the file ends before
    else if (byte == 0.0)
        kind = 2.0;                  // NUL
    else if (byte == 10.0)
        kind = 3.0;                  // line feed
    else if (byte == 13.0)
        kind = 4.0;                  // carriage return
    else if (byte >= 128.0)
        kind = 5.0;                  // no ASCII

    vec3 color = vec3(0.12, 0.14, 0.17);
    if (kind == 1.0)
        color = byte == 32.0 ? vec3(0.22, 0.26, 0.32)
            : mix(vec3(0.30, 0.38, 0.50), vec3(0.62, 0.70, 0.80), (byte - 33.0) / 94.0);
    else if (kind == 2.0)
        color = vec3(0.02);
    else if (kind == 3.0)
        color = vec3(0.35, 0.75, 0.45);
    else if (kind == 4.0)
        color = vec3(0.95, 0.70, 0.25);
    else if (kind == 5.0)
        color = vec3(0.88, 0.30, 0.25);
    vec2 off = abs(fract(field) - 0.5);
    float gap = max(off.x, off.y) > 0.42 ? 0.0 : 1.0;
    FragColor = vec4(mix(vec3(0.07, 0.08, 0.10), color, gap), 1.0);
}
