#version 330 core
struct Material {
    vec3 ambient;
    float shininess;
};

uniform float f;
uniform int i;
uniform uint u;
uniform vec3 v3;
uniform float fv[4];
uniform vec2 pairs[2];
uniform Material material;
uniform mat2x3 m;

layout (location = 0) out float fOut;
layout (location = 1) out int iOut;
layout (location = 2) out uint uOut;
layout (location = 3) out vec3 v3Out;
layout (location = 4) out vec4 fvOut;
layout (location = 5) out vec4 pairsOut;
layout (location = 6) out vec4 materialOut;
layout (location = 7) out vec4 mOut;

void main()
{
    fOut = f;
    iOut = i;
    uOut = u;
    v3Out = v3;
    fvOut = vec4(fv[0], fv[1], fv[2], fv[3]);
    pairsOut = vec4(pairs[0], pairs[1]);
    materialOut = vec4(material.ambient, material.shininess);
    mOut = vec4(m[0], m[1].z);   // the first column, and the second one's end
}
