#version 330 core
uniform vec2 someVec;

layout (location = 0) out vec4 differentVec;
layout (location = 1) out vec3 anotherVec;
layout (location = 2) out vec4 otherVec;
layout (location = 3) out vec4 asColor;
layout (location = 4) out vec4 asTexture;
layout (location = 5) out vec4 written;

void main()
{
    differentVec = someVec.xyxx;
    anotherVec = differentVec.zyw;
    otherVec = someVec.xxxx + anotherVec.yxzy;

    // The same components under their other names.
    asColor = someVec.rgrr;
    asTexture = someVec.stss;

    // On the left of an assignment a swizzle chooses what is written, and where.
    written = vec4(0.0);
    written.wy = someVec;
}
