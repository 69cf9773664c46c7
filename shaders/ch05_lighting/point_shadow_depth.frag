#version 330 core
in vec3 FragPos;

uniform vec3 lightPos;
uniform float farPlane;

void main()
{
    // The distance itself: a window depth would be another one on each face.
    gl_FragDepth = length(FragPos - lightPos) / farPlane;
}
