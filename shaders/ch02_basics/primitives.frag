#version 330 core
out vec4 FragColor;

void main()
{
    // The draw's first primitive is amber, its sixth would be blue.
    float share = 0.2 * float(gl_PrimitiveID);
    FragColor = vec4(mix(vec3(1.0, 0.72, 0.25), vec3(0.2, 0.45, 1.0), share), 1.0);
}
