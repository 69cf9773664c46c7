#version 330 core
uniform float bit;   // what the stored bit that lets this draw through is worth

out float stored;

void main()
{
    // Drawn once for each bit and added up: the sum is the stored value.
    stored = bit;
}
