#version 330 core
layout (location = 0) in vec2 aPos;    // −1 … 1 over the target
layout (location = 1) in float aGap;   // how much farther this corner is

uniform float near;
uniform float far;
uniform float middle;   // distance of the wall's middle
uniform float slant;    // how much farther its right edge is
uniform float rise;     // how much farther its upper edge is

void main()
{
    // The wall is seen under the same angle, whatever its distance is.
    float z = middle + slant * aPos.x + rise * aPos.y + aGap;
    float depth = (far + near) / (far - near) * z - 2.0 * far * near / (far - near);
    gl_Position = vec4(aPos * z, depth, z);
}
