#version 330 core
layout (location = 0) in vec3 aPos;

uniform bool turned;   // seen from behind: x is mirrored, and with it the winding

void main()
{
    // Depth grows away from the viewer, who is at +z: the near face is the one with the larger z.
    gl_Position = vec4(turned ? -aPos.x : aPos.x, aPos.y, -aPos.z, 1.0);
}
