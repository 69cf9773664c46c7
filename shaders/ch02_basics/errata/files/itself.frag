#version 330 core
#include "itself.frag"
