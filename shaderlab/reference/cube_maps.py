"""Cube maps: the face that a direction selects, and reflected and refracted rays.

Source: "The OpenGL Graphics System: A Specification", version 4.5 core (M. Segal, K. Akeley,
2017), section 8.13, table 8.19 (selection of cube map images). Reflection and refraction: N.
Greene, "Environment Mapping and Other Applications of World Projections", IEEE Computer Graphics
and Applications 6 (11), 1986; Snell's law as GLSL 4.60, section 8.5, states it.
"""

from __future__ import annotations

from ..glslmath import Value, abs, dot, max, normalize, reflect, refract, swizzle, vec3, where


def face_coordinates(direction: Value) -> Value:
    """The face that a direction selects, with s and t on it: (…, 3), the face as 0…5 for +X, −X,
    +Y, −Y, +Z, −Z. Where two components are equal, x goes before y, and y before z.

    The direction is (…, 3), of any length but 0.

    >>> face_coordinates(np.array([2.0, 0.5, -1.0])).tolist()
    [0.0, 0.75, 0.375]
    >>> face_coordinates(np.array([0.25, -1.0, 0.5])).tolist()
    [3.0, 0.625, 0.25]
    """
    x, y, z = (swizzle(direction, name) for name in "xyz")
    along = vec3(abs(x), abs(y), abs(z))
    largest = max(max(abs(x), abs(y)), abs(z))
    by_z = vec3(where(z > 0.0, 4.0, 5.0), where(z > 0.0, x, -x), -y)
    by_y = vec3(where(y > 0.0, 2.0, 3.0), x, where(y > 0.0, z, -z))
    by_x = vec3(where(x > 0.0, 0.0, 1.0), where(x > 0.0, -z, z), -y)
    chosen = where(swizzle(along, "y") >= swizzle(along, "z"), by_y, by_z)
    is_x = (swizzle(along, "x") >= swizzle(along, "y")) & (
        swizzle(along, "x") >= swizzle(along, "z")
    )
    chosen = where(is_x, by_x, chosen)
    places = 0.5 * (swizzle(chosen, "yz") / largest + 1.0)
    return vec3(swizzle(chosen, "x"), places)


def mirrored(FragPos: Value, Normal: Value, cameraPos: Value) -> Value:
    """The viewer's ray off a mirror: reflect(normalize(P − C), N), (…, 3).

    >>> mirrored(np.zeros(3), np.array([0.0, 1, 0]), np.array([3.0, 4, 0])).round(9).tolist()
    [-0.6, 0.8, 0.0]
    """
    return reflect(normalize(FragPos - cameraPos), normalize(Normal))


def bent(FragPos: Value, Normal: Value, cameraPos: Value, ratio: Value) -> Value:
    """The viewer's ray into glass: refract(normalize(P − C), N, n₁/n₂), (…, 3).

    The ratio is that of the indices, outside over inside; 1.00/1.52 for air and glass.

    >>> ray = bent(np.zeros(3), np.array([0.0, 1, 0]), np.array([3.0, 4, 0]), 1.0 / 1.52)
    >>> ray.round(6).tolist()
    [-0.394737, -0.918794, 0.0]
    """
    return refract(normalize(FragPos - cameraPos), normalize(Normal), ratio)


def fresnel(FragPos: Value, Normal: Value, cameraPos: Value, base: Value) -> Value:
    """Reflectance by Schlick's approximation: F₀ + (1 − F₀)(1 − cos θ)⁵, (…, 1).

    Source: C. Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", Computer
    Graphics Forum 13 (3), 1994, equation 15.

    >>> fresnel(np.zeros(3), np.array([0.0, 1, 0]), np.array([0.0, 4, 0]), 0.04).tolist()
    [0.04]
    """
    cosine = max(dot(normalize(Normal), normalize(cameraPos - FragPos)), 0.0)
    missing = 1.0 - cosine
    squared = missing * missing
    return base + (1.0 - base) * (squared * squared * missing)
