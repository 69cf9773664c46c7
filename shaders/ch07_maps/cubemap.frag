#version 330 core
#include "lib/cube_face.glsl"

in vec3 direction;

uniform samplerCube faces;     // says of each texel on which face it is, and where
uniform float stretch;         // a direction's length, which must not matter

out vec4 FragColor;
out vec3 byHand;               // face, s and t by the table
out vec4 onceMore;             // the texel that direction of another length meets

void main()
{
    FragColor = textureLod(faces, direction, 0.0);
    byHand = cubeFace(direction);
    onceMore = textureLod(faces, direction * stretch, 0.0);
}
