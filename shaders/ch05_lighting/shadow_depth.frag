#version 330 core

// Nothing to colour: the depth attachment is the picture.
void main()
{
}
