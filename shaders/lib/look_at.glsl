// The view matrix of a camera at `eye` that looks at `target`, with `up` upwards in its picture.

mat4 lookAt(vec3 eye, vec3 target, vec3 up)
{
    vec3 forward = normalize(target - eye);
    vec3 side = normalize(cross(forward, up));   // not of length 1 before, unless up is at right angles
    vec3 above = cross(side, forward);

    // Rows are the camera's axes, so that each gives its coordinate; column by column as GLSL reads.
    return mat4(
        vec4(side.x, above.x, -forward.x, 0.0),
        vec4(side.y, above.y, -forward.y, 0.0),
        vec4(side.z, above.z, -forward.z, 0.0),
        vec4(-dot(side, eye), -dot(above, eye), dot(forward, eye), 1.0));
}
