"""The two classic specular lobes.

Sources: B. T. Phong, "Illumination for Computer Generated Pictures", Communications of the ACM
18(6), 1975 (the reflected ray); J. F. Blinn, "Models of Light Reflection for Computer Synthesized
Pictures", SIGGRAPH 1977 (the halfway vector).

All directions point away from the surface and need not be of unit length, but not of length 0.
"""

from __future__ import annotations

from shaderlab.glslmath import Value, dot, max, normalize, pow, reflect, where


def lobe(cosine: Value, shininess: Value) -> Value:
    """cosineˢ, and 0 where the cosine is not positive (there GLSL's pow is undefined).

    >>> print(f"{lobe(0.5, 2.0).item():.2f} {lobe(-0.5, 2.0).item():.2f}")
    0.25 0.00
    """
    return where(cosine > 0.0, pow(cosine, shininess), 0.0)


def phong(normal: Value, light_direction: Value, view_direction: Value, shininess: Value) -> Value:
    """(R·V)ˢ with R the reflected light: 0 where R and V are 90° or more apart.

    Args:
        normal, light_direction, view_direction: (…, 3).
        shininess: s > 0, without unit.

    Returns:
        0…1, (…, 1).

    >>> from shaderlab.glslmath import vec3
    >>> up, aside = vec3(0.0, 0.0, 1.0), vec3(0.6, 0.0, 0.8)
    >>> print(f"{phong(up, aside, up, 2.0).item():.6f}")
    0.640000
    """
    mirrored = reflect(-normalize(light_direction), normalize(normal))
    return lobe(dot(mirrored, normalize(view_direction)), shininess)


def blinn(normal: Value, light_direction: Value, view_direction: Value, shininess: Value) -> Value:
    """(N·H)ˢ with H halfway between light and viewer: never cut off while both see the surface.

    Args and returns: as `phong`.

    >>> from shaderlab.glslmath import vec3
    >>> up, aside = vec3(0.0, 0.0, 1.0), vec3(0.6, 0.0, 0.8)
    >>> print(f"{blinn(up, aside, up, 2.0).item():.6f}")
    0.900000
    """
    halfway = normalize(normalize(light_direction) + normalize(view_direction))
    return lobe(dot(normalize(normal), halfway), shininess)


def diffuse(normal: Value, light_direction: Value) -> Value:
    """Lambert's law: max(N·L, 0). Source: J. H. Lambert, "Photometria", 1760.

    >>> from shaderlab.glslmath import vec3
    >>> print(f"{diffuse(vec3(0.0, 0.0, 1.0), vec3(1.2, 1.0, 2.0)).item():.6f}")
    0.788110
    """
    return max(dot(normalize(normal), normalize(light_direction)), 0.0)
