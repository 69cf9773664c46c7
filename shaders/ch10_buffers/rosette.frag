#version 330 core
in vec3 ourColor;

out vec4 FragColor;

void main()
{
    // Light is mixed, then encoded for the display by a square root, close to its gamma.
    FragColor = vec4(sqrt(ourColor), 1.0);
}
