vec4 colour()
{
    return vec4(0.25, 0.5, 0.75, 1.0);
}
