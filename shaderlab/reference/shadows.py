"""Shadow maps: comparing a point's depth, seen from the light, with the nearest one stored.

Sources: L. Williams, "Casting Curved Shadows on Curved Surfaces", SIGGRAPH 1978 (the depth
comparison, and the constant bias against surfaces that shadow themselves); the bias that grows
with the slope: J. de Vries, "Learn OpenGL" (2020), chapter "Shadow mapping",
max(m·(1 − N·L), b); W. Reeves, D. Salesin, R. Cook, "Rendering Antialiased Shadows with Depth
Maps", SIGGRAPH 1987 (percentage-closer filtering: comparisons are averaged, not depths).

Depths are window depths, 0 next to the light and 1 at its far plane.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from shaderlab.glslmath import Value, dot, max, normalize, swizzle, vec2, vec3, where


def shadow_coordinates(light_space: Value) -> Value:
    """Where in the shadow map a point is: clip coordinates seen from the light, divided by w and
    moved from −1…1 to 0…1. Its (x, y) are texture coordinates, z the depth to compare.

    Args:
        light_space: clip coordinates (…, 4), w > 0.

    Returns:
        (…, 3); inside the map where all lie in 0…1.

    >>> shadow_coordinates(np.array([0.0, 1.0, -1.0, 2.0])).tolist()
    [0.5, 0.75, 0.25]
    """
    return swizzle(light_space, "xyz") / swizzle(light_space, "w") * 0.5 + 0.5


def slope_bias(normal: Value, light_direction: Value, least: Value, most: Value) -> Value:
    """A bias that grows as light grazes the surface: max(most·(1 − N·L), least).

    Args:
        normal, light_direction: N and L, away from the surface, (…, 3), of any length but 0.
        least: where light falls straight down, in depth.
        most: where it grazes.

    Returns:
        A depth, (…, 1).

    >>> from shaderlab.glslmath import vec3
    >>> up, aside = vec3(0.0, 0.0, 1.0), vec3(0.0, 0.6, 0.8)
    >>> print(f"{slope_bias(up, aside, 0.005, 0.05).item():.6f}")
    0.010000
    """
    cosine = dot(normalize(normal), normalize(light_direction))
    return max(most * (1.0 - cosine), least)


def shadow(current: Value, closest: Value, bias: Value = 0.0) -> Value:
    """1 in shadow, 0 in light: whether current − bias > closest. Beyond the light's far plane
    (current > 1) nothing is shadowed, since nothing was stored there.

    Args:
        current: the point's depth from the light.
        closest: the depth stored in the map, 0…1.
        bias: what a surface may lie behind itself.

    >>> [float(shadow(z, 0.5, 0.01)) for z in (0.505, 0.52, 1.5)]
    [0.0, 1.0, 0.0]
    """
    return where(current > 1.0, 0.0, where(current - bias > closest, 1.0, 0.0))


def shadow_of_fragment(texture: Callable[[Any, Value], Value]) -> Callable[..., Value]:
    """How dark the map says that a fragment is, from the inputs of the shadow cases' shader.

    Args:
        texture: how the map is read; `shaderlab.sampling.texture`.

    Returns:
        a function of the fragment's normal, its place in the light's clip space, the map, the
        direction to the light, the two biases and the radius of the texels to be asked.

    >>> class Map:
    ...     texels = type("Texels", (), {"values": np.zeros((4, 4, 1))})
    >>> dark = shadow_of_fragment(lambda map, uv: np.array([[0.3, 0.0, 0.0, 1.0]]))
    >>> up, middle = np.array([[0.0, 1.0, 0.0]]), np.array([[0.0, 0.0, 0.0, 1.0]])
    >>> float(dark(up, middle, Map, np.array([0.0, 1.0, 0.0]), 0.0, 0.0, 0).item())
    1.0
    """

    def shadow(
        Normal: Value,
        FragPosLightSpace: Value,
        shadowMap: Any,
        lightPos: Value,
        leastBias: Value,
        mostBias: Value,
        radius: Value,
    ) -> Value:
        place = shadow_coordinates(FragPosLightSpace)
        bias = slope_bias(Normal, lightPos, leastBias, mostBias)
        height, width = shadowMap.texels.values.shape[:2]
        reach = range(-whole(radius), whole(radius) + 1)
        closest = [
            swizzle(texture(shadowMap, swizzle(place, "xy") + vec2(x / width, y / height)), "x")
            for y in reach
            for x in reach
        ]
        return filtered_shadow(swizzle(place, "z"), closest, bias)

    return shadow


def compared_shadow(texture: Callable[[Any, Value], Value]) -> Callable[..., Value]:
    """How dark a fragment is for a sampler that compares by itself, by GL_LEQUAL: 1 − the share
    of the texels around whose depth is at least the fragment's.

    Args:
        texture: how the map is read; `shaderlab.sampling.texture`.

    Returns:
        a function of the fragment's normal, its place in the light's clip space, the map, the
        direction to the light and the two biases.

    >>> dark = compared_shadow(lambda map, p: np.where(p[..., 2:] <= map, 1.0, 0.0))
    >>> up, middle = np.array([[0.0, 1.0, 0.0]]), np.array([[0.0, 0.0, 0.0, 1.0]])
    >>> [dark(up, middle, depth, up, 0.01, 0.0).item() for depth in (0.3, 0.495)]
    [1.0, 0.0]
    """

    def shadow(
        Normal: Value,
        FragPosLightSpace: Value,
        shadowMap: Any,
        lightPos: Value,
        leastBias: Value,
        mostBias: Value,
    ) -> Value:
        place = shadow_coordinates(FragPosLightSpace)
        depth = swizzle(place, "z")
        bias = slope_bias(Normal, lightPos, leastBias, mostBias)
        bright = texture(shadowMap, vec3(swizzle(place, "xy"), depth - bias))
        return where(depth > 1.0, 0.0, 1.0 - bright)

    return shadow


def whole(number: Any) -> int:
    """An integer uniform, given as a number, an array or a band of one value.

    >>> whole(2.0)
    2
    """
    return int(np.ravel(getattr(number, "lo", number))[0])


def filtered_shadow(current: Value, closest: Sequence[Value], bias: Value = 0.0) -> Value:
    """Percentage-closer filtering: the mean of `shadow` over neighbouring texels, nine for 3 × 3.

    >>> float(filtered_shadow(0.5, [0.4, 0.6, 0.7, 0.3]))
    0.5
    """
    total: Value = 0.0
    for depth in closest:
        total = total + shadow(current, depth, bias)
    return total / float(len(closest))
