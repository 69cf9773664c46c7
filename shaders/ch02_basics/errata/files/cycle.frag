#version 330 core
#include "cycle_back.frag"
