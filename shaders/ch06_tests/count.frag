#version 330 core
uniform float worth;   // what this draw adds wherever it is let through

out float total;

void main()
{
    total = worth;
}
