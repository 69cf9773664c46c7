"""What the two shaders of the shadow cases must give, output by output.

Sources: as in `shaderlab.reference.shadows` and, for the lamp's terms, in
`shaderlab.reference.lighting`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from shaderlab.glslmath import Value, mul, normalize, swizzle, vec2, vec3, vec4, where
from shaderlab.reference.lighting import blinn, diffuse
from shaderlab.reference.shadows import filtered_shadow, shadow_coordinates, slope_bias
from shaderlab.reference.transforms import clip_position, world_normal, world_position

from .studio import handed_on

Reference = Callable[..., Any]


def light_position(aPos: Value, model: Value, lightSpaceMatrix: Value) -> Value:
    """Clip coordinates seen from the light, (…, 4).

    >>> light_position(np.ones(3), np.eye(4), 2.0 * np.eye(4)).tolist()
    [2.0, 2.0, 2.0, 2.0]
    """
    return mul(lightSpaceMatrix, mul(model, vec4(aPos, 1.0)))


def stored_depth(frag_coord: Value) -> Value:
    """What a shadow map keeps of a fragment: its window depth.

    >>> stored_depth(np.array([3.5, 4.5, 0.25, 1.0])).tolist()
    [0.25]
    """
    return swizzle(frag_coord, "z")


def unit_normal(Normal: Value) -> Value:
    """The interpolated normal, of length 1 again.

    >>> unit_normal(np.array([0.0, 3.0, 4.0])).tolist()
    [0.0, 0.6, 0.8]
    """
    return normalize(Normal)


def seen_place(FragPos: Value) -> Value:
    """The fragment's place in the world.

    >>> seen_place(2.0)
    2.0
    """
    return FragPos


def sunlit(
    FragPos: Value, Normal: Value, Color: Value, shadow: Value, lightPos: Value, viewPos: Value
) -> Value:
    """(0.15 + (1 − s)(N·L + 0.2 (N·H)³²)) · colour: a shadow takes the sun, not the sky.

    Args:
        FragPos, viewPos: places, (…, 3).
        Normal, lightPos: directions of any length, the latter to the sun.
        Color: (…, 3).
        shadow: s, 0 … 1.

    >>> up, grey = np.array([0.0, 1.0, 0.0]), np.full(3, 0.5)
    >>> sunlit(np.zeros(3), up, grey, 1.0, up, up).round(6).tolist()
    [0.075, 0.075, 0.075, 1.0]
    """
    glint = 0.2 * blinn(Normal, lightPos, viewPos - FragPos, 32.0)
    return vec4((0.15 + (1.0 - shadow) * (diffuse(Normal, lightPos) + glint)) * Color, 1.0)


def shadow_of_fragment(texture: Callable[[Any, Value], Value]) -> Callable[..., Value]:
    """How dark the map says that a fragment is, from the inputs of shadow_map.frag.

    Args:
        texture: how the map is read; `shaderlab.glslmath.sampling.texture`.

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
        texture: how the map is read; `shaderlab.glslmath.sampling.texture`.

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


def courtyard_references(texture: Callable[[Any, Value], Value]) -> Mapping[str, Reference]:
    """A reference for each output of the pass from the camera.

    Args:
        texture: how the shadow map is read; `shaderlab.glslmath.sampling.texture`.

    >>> sorted(courtyard_references(lambda map, uv: uv))[:3]
    ['Color', 'FragColor', 'FragPos']
    """
    dark = shadow_of_fragment(texture)

    def color(
        FragPos: Value, Normal: Value, Color: Value, FragPosLightSpace: Value, shadowMap: Any,
        lightPos: Value, viewPos: Value, leastBias: Value, mostBias: Value, radius: Value,
    ) -> Value:  # fmt: skip
        shadow = dark(Normal, FragPosLightSpace, shadowMap, lightPos, leastBias, mostBias, radius)
        return sunlit(FragPos, Normal, Color, shadow, lightPos, viewPos)

    return {
        "gl_Position": clip_position,
        "FragPos": world_position,
        "Normal": world_normal,
        "FragPosLightSpace": light_position,
        "Color": handed_on,
        "shadow": dark,
        "place": seen_place,
        "upright": unit_normal,
        "FragColor": color,
    }
