#version 330 core
out vec4 color;
float f() { return 1.0; }
