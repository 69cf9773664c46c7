#version 330 core
#include "lib/solids.glsl"

in vec3 place;

out float away;

void main()
{
    away = toScene(place);
}
