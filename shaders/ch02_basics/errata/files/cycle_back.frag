#version 330 core

#include "cycle.frag"
