"""Shadow maps: a point's depth from the light, compared with the nearest depth stored.

Sources: L. Williams, "Casting Curved Shadows on Curved Surfaces", SIGGRAPH 1978 (the depth
comparison, and the constant bias against surfaces that shadow themselves); the bias that grows
with the slope: J. de Vries, "Learn OpenGL" (2020), chapter "Shadow mapping",
max(m·(1 − N·L), b); W. Reeves, D. Salesin, R. Cook, "Rendering Antialiased Shadows with Depth
Maps", SIGGRAPH 1987 (percentage-closer filtering: comparisons are averaged, not depths).

Depths are window depths, 0 next to the light and 1 at its far plane.
"""

from __future__ import annotations

from collections.abc import Sequence

from shaderlab.glslmath import Value, dot, max, normalize, swizzle, where


def shadow_coordinates(light_space: Value) -> Value:
    """A point's place in the shadow map: the light's clip coordinates, divided by w and mapped
    from −1…1 to 0…1. Its (x, y) are texture coordinates, z the depth to compare.

    Takes clip coordinates (…, 4), w > 0; returns (…, 3), inside the map where all lie in 0…1.

    >>> shadow_coordinates(np.array([0.0, 1.0, -1.0, 2.0])).tolist()
    [0.5, 0.75, 0.25]
    """
    return swizzle(light_space, "xyz") / swizzle(light_space, "w") * 0.5 + 0.5


def slope_bias(normal: Value, light_direction: Value, least: Value, most: Value) -> Value:
    """A bias that grows towards grazing light: max(most·(1 − N·L), least).

    Args:
        normal, light_direction: N and L, away from the surface, (…, 3), of any length but 0.
        least: where light falls straight down, in depth.
        most: where it grazes.

    Returns a depth, (…, 1).

    >>> from shaderlab.glslmath import vec3
    >>> up, aside = vec3(0.0, 0.0, 1.0), vec3(0.0, 0.6, 0.8)
    >>> print(f"{slope_bias(up, aside, 0.005, 0.05).item():.6f}")
    0.010000
    """
    cosine = dot(normalize(normal), normalize(light_direction))
    return max(most * (1.0 - cosine), least)


def shadow(current: Value, closest: Value, bias: Value = 0.0) -> Value:
    """1 in shadow, 0 in light: whether current − bias > closest. Nothing is shadowed beyond the
    light's far plane (current > 1), where nothing was stored.

    Args:
        current: the point's depth from the light.
        closest: the depth stored in the map, 0…1.
        bias: how far behind the stored depth a point still counts as lit.

    >>> [float(shadow(z, 0.5, 0.01)) for z in (0.505, 0.52, 1.5)]
    [0.0, 1.0, 0.0]
    """
    return where(current > 1.0, 0.0, where(current - bias > closest, 1.0, 0.0))


def filtered_shadow(current: Value, closest: Sequence[Value], bias: Value = 0.0) -> Value:
    """Percentage-closer filtering: the mean of `shadow` over neighbouring texels, nine for 3 × 3.

    >>> float(filtered_shadow(0.5, [0.4, 0.6, 0.7, 0.3]))
    0.5
    """
    total: Value = 0.0
    for depth in closest:
        total = total + shadow(current, depth, bias)
    return total / float(len(closest))
