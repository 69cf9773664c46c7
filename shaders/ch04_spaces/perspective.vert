#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform mat4 view;
uniform float fovy;     // the opening from bottom to top, in radians
uniform float aspect;   // width / height
uniform float near;
uniform float far;

out vec3 Normal;
out vec3 Color;
out vec3 Ndc;

void main()
{
    float focal = 1.0 / tan(fovy / 2.0);
    mat4 projection = mat4(0.0);
    projection[0][0] = focal / aspect;
    projection[1][1] = focal;
    projection[2][2] = (far + near) / (near - far);
    projection[2][3] = -1.0;   // w becomes −z, the distance in front of the camera
    projection[3][2] = 2.0 * far * near / (near - far);

    Normal = aNormal;
    Color = aColor;
    gl_Position = projection * (view * vec4(aPos, 1.0));
    Ndc = gl_Position.xyz / gl_Position.w;
}
