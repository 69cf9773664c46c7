// A unit quaternion q = (u sin φ/2, cos φ/2) turns by φ around the unit axis u.

vec4 product(vec4 p, vec4 q)
{
    return vec4(p.w * q.xyz + q.w * p.xyz + cross(p.xyz, q.xyz), p.w * q.w - dot(p.xyz, q.xyz));
}

vec3 turned(vec3 v, vec4 q)
{
    vec4 conjugate = vec4(-q.xyz, q.w);
    return product(product(q, vec4(v, 0.0)), conjugate).xyz;
}
