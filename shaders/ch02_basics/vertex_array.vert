#version 330 core
layout (location = 0) in vec3 aPos;

out float height;   // 0 at the foot, 1 at the tip

void main()
{
    height = aPos.y + 0.5;
    gl_Position = vec4(aPos, 1.0);
}
