#version 330 core
layout (location = 0) in vec3 aPos;   // local space
layout (location = 1) in vec3 aNormal;
layout (location = 3) in vec3 aColor;

uniform mat4 model;
uniform mat3 normalMatrix;
uniform mat4 view;
uniform mat4 projection;
uniform vec4 viewport;   // x, y, width, height

uniform int space;       // which of the six is on show: 0 local … 5 window
uniform mat4 watch;      // how the onlooker sees that space

out vec3 Normal;
out vec3 Color;
out vec4 World;
out vec4 View;
out vec4 Clip;
out vec3 Ndc;
out vec3 Window;

void main()
{
    World = model * vec4(aPos, 1.0);
    View = view * World;
    Clip = projection * View;
    Ndc = Clip.xyz / Clip.w;
    Window.xy = 0.5 * viewport.zw * Ndc.xy + (viewport.xy + 0.5 * viewport.zw);
    Window.z = 0.5 * Ndc.z + 0.5;

    Normal = normalMatrix * aNormal;
    Color = aColor;

    vec3 shown[6] = vec3[6](aPos, World.xyz, View.xyz, Clip.xyz, Ndc, Window);
    gl_Position = watch * vec4(shown[space], 1.0);
}
