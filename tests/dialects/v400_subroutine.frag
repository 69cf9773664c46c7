#version 400 core
subroutine float Shape(float x);
subroutine (Shape) float plain(float x) { return x; }
subroutine uniform Shape shape;
out vec4 color;
void main() { color = vec4(shape(1.0)); }
