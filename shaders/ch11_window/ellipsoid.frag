#version 330 core
in vec3 Local;

uniform mat3 normalMatrix;
uniform vec3 axes;
uniform vec3 lightDir;
uniform bool stretched;   // the mistake: the sphere's normals, stretched along with it

layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec3 normal;
layout (location = 2) out float covered;
layout (location = 3) out float facing;   // 1 where the side that we see is the outer one

void main()
{
    vec3 gradient = stretched ? Local : Local / (axes * axes);
    normal = normalize(normalMatrix * gradient);

    // Lines at equal heights of the sphere that it was.
    vec3 unit = Local / axes;
    float lines = abs(fract(6.0 * unit.y) - 0.5) > 0.46 ? 0.75 : 1.0;
    float light = 0.16 + 0.84 * max(dot(normal, lightDir), 0.0);
    FragColor = vec4(light * lines * vec3(0.95, 0.62, 0.30), 1.0);
    covered = 1.0;
    facing = gl_FrontFacing ? 1.0 : 0.0;
}
