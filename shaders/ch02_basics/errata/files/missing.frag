#version 330 core
#include "ch02_basics/errata/files/folder.frag/color.glsl"
