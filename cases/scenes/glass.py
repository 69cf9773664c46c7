"""Petals of glass on a wheel, as lib/glass.glsl has them: each lies over the next, all the way
around.

Source: M. McGuire, L. Bavoil, "Weighted Blended Order-Independent Transparency", Journal of
Computer Graphics Techniques 2(2), 2013 (weights that fall with the cube of the depth, equation 10).

Places are (…, 2), depths and weights (…, 1).
"""

from __future__ import annotations

import math
from typing import Any

from shaderlab.glslmath import Value, clamp, distance, dot, mix, smoothstep, vec4

PETALS = 6
_RADIUS = 0.52
_HUES = (
    (0.85, 0.05, 0.06),
    (0.90, 0.40, 0.02),
    (0.80, 0.72, 0.04),
    (0.05, 0.45, 0.12),
    (0.03, 0.22, 0.75),
    (0.36, 0.05, 0.55),
)


def petal(k: int, pixel: float) -> dict[str, Any]:
    """The uniforms of a petal: where it stands on the wheel, and how it leans along it.

    Args:
        k: its number, 0…5.
        pixel: how wide its soft edge is.

    >>> petal(1, 0.1)["petal.color"]
    (0.9, 0.4, 0.02)
    """
    turn = math.tau * (k + 0.19) / PETALS
    return {
        "petal.centre": (0.44 * math.cos(turn), 0.44 * math.sin(turn)),
        "petal.lean": (-0.35 * math.sin(turn), 0.35 * math.cos(turn)),
        "petal.color": _HUES[k],
        "pixel": pixel,
    }


def cover(place: Value, petal_centre: Value, pixel: Value) -> Value:
    """α: how much of what is behind it a petal hides.

    >>> import numpy as np
    >>> cover(np.array([0.2, 0.0]), np.zeros(2), 0.1).tolist()
    [0.5]
    """
    away = distance(place, petal_centre)
    inside = clamp((_RADIUS - away) / pixel + 0.5, 0.0, 1.0)
    return inside * mix(0.5, 0.85, smoothstep(_RADIUS - 0.09, _RADIUS - 0.02, away))


def depth(place: Value, petal_lean: Value) -> Value:
    """How far a petal is, 0…1.

    >>> import numpy as np
    >>> depth(np.array([0.2, 0.0]), np.array([0.5, 0.0])).tolist()
    [0.6]
    """
    return 0.5 + dot(petal_lean, place)


def layer(place: Value, petal_centre: Value, petal_color: Value, pixel: Value) -> Value:
    """A petal's colour, and its α.

    >>> import numpy as np
    >>> layer(np.zeros(2), np.zeros(2), np.ones(3), 0.1).tolist()
    [1.0, 1.0, 1.0, 0.5]
    """
    return vec4(petal_color, cover(place, petal_centre, pixel))


def weight(alpha: Value, depth: Value) -> Value:
    """What a layer counts in the mean: α times what falls with the depth.

    >>> weight(0.5, 0.5).item()
    1.875
    """
    nearness = 1.0 - depth
    return alpha * clamp(30.0 * nearness * nearness * nearness, 0.01, 300.0)
