#version 330 core
out float lit;

void main()
{
    lit = 1.0;
}
