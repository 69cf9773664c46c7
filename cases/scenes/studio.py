"""The light in which scenes about transforms are shown, and the softening of their edges.

Source: J. H. Lambert, "Photometria", 1760 (the cosine law); a sky of even brightness seen from a
surface facing n lights it in proportion to (1 + n·up) / 2.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from shaderlab.glslmath import Value, dot, max, min, normalize, swizzle, vec3, vec4

from .drawing import encoded


def studio_color(Color: Value, Normal: Value) -> Value:
    """Colour of a surface under the studio's lamp and sky, encoded with a gamma of 2.2.

    Args:
        Color: the surface's own colour, (…, 3), linear, 0…1.
        Normal: of any length but 0, (…, 3).

    Returns:
        (…, 4), alpha 1.

    >>> studio_color(np.array([0.5, 0.5, 0.5]), np.array([0.0, 2.0, 0.0])).round(6).tolist()
    [0.742866, 0.742866, 0.742866, 1.0]
    """
    normal = normalize(Normal)
    lamp = max(dot(normal, vec3(-0.36, 0.80, 0.48)), 0.0)
    sky = 0.5 + 0.5 * swizzle(normal, "y")
    light = Color * (0.30 + 0.30 * sky + 0.55 * lamp)
    return vec4(encoded(light), 1.0)


def handed_on(aColor: Value) -> Value:
    """A vertex's colour, which the vertex shader only passes on.

    >>> handed_on(0.25)
    0.25
    """
    return aColor


def finished(texture: Callable[[Any, Value], Value]) -> Callable[..., Value]:
    """A picture of a scene drawn twice as large: the mean of four texels, encoded for a display.

    Each texel is cut to what a display can show before the mean is taken, so that a bright
    point does not make its neighbours white; a gamma of 2.2 encodes.

    Args:
        texture: how the scene is read; `shaderlab.glslmath.sampling.texture`.

    >>> class Scene:
    ...     texels = type("Texels", (), {"values": np.zeros((4, 4, 1))})
    >>> made = finished(lambda scene, uv: vec4(uv, 2.0, 1.0))(Scene, np.array([0.5, 0.25]))
    >>> made.round(6).tolist()
    [0.72974, 0.532521, 1.0, 1.0]
    """

    def halved(scene: Any, TexCoords: Value) -> Value:
        return mean_of_four(scene, TexCoords, lambda at: min(texture(scene, at), 1.0))

    return halved


def mean_of_four(scene: Any, TexCoords: Value, shown: Callable[[Value], Value]) -> Value:
    """The mean of four texels around a place, encoded for a display.

    Args:
        scene: a sampler.
        TexCoords: the place, between the four.
        shown: what a display can show of the texel at a place.

    >>> class Scene:
    ...     texels = type("Texels", (), {"values": np.zeros((4, 4, 1))})
    >>> mean_of_four(Scene, np.zeros(2), lambda at: vec3(0.5)).round(6).tolist()
    [0.72974, 0.72974, 0.72974, 1.0]
    """
    height, width = scene.texels.values.shape[:2]
    across, up = 0.5 / width, 0.5 / height

    def near(x: float, y: float) -> Value:
        return swizzle(shown(TexCoords + np.array([x, y])), "xyz")

    total = near(-across, -up) + near(across, up) + near(-across, up) + near(across, -up)
    return vec4(encoded(0.25 * total), 1.0)
