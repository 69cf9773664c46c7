#version 330 core
layout (location = 0) in vec3 aPos;   // −1 … 1 over the cell

uniform float near;
uniform float far;
uniform float middle;   // distance of the wall's middle
uniform float slant;    // how much farther its right edge is
uniform float rise;     // how much farther its upper edge is
uniform float gap;      // how much farther all of it is

void main()
{
    // A wall that fills the cell, whatever its distance is.
    float z = middle + slant * aPos.x + rise * aPos.y + gap;
    float depth = (far + near) / (far - near) * z - 2.0 * far * near / (far - near);
    gl_Position = vec4(aPos.xy * z, depth, z);
}
