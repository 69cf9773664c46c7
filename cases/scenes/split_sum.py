"""Light from everywhere on a glossy surface, as lib/split_sum.glsl has it.

Sources: B. Karis, "Real Shading in Unreal Engine 4", SIGGRAPH course, 2013 (the split sum); J.
M. Hammersley, D. C. Handscomb, "Monte Carlo Methods", 1964 (points by the radical inverse); Walter
et al. 2007, equation 35 (halfway vectors as GGX's D is distributed).
"""

from __future__ import annotations

import math
from functools import reduce
from operator import add

import numpy as np

from shaderlab.glslmath import Value, dot, max, sqrt, swizzle, vec2, vec3
from shaderlab.reference.microfacets import shadowing_under_sky

SAMPLES = 32
_TURN = 2.0 * math.pi / SAMPLES * np.arange(SAMPLES)
AZIMUTHS = np.column_stack([np.cos(_TURN), np.sin(_TURN)])
FRACTIONS = np.array([int(f"{k:032b}"[::-1], 2) / 2.0**32 for k in range(SAMPLES)])
"""Of each point, a direction around the normal, and its number's bits in opposite order."""


def halfways(roughness: Value) -> Value:
    """All halfway vectors about +z, for mirrors whose D is GGX's, (SAMPLES, …, 3).

    >>> halfways(0.5)[0].tolist()
    [[0.0, 0.0, 1.0]]
    """
    u, squared = FRACTIONS[:, None, None], roughness * roughness * roughness * roughness
    around = 1.0 - u + squared * u
    azimuths = AZIMUTHS.astype(np.float32)[:, None]
    return vec3(sqrt(squared * u / around) * azimuths, sqrt((1.0 - u) / around))


def factors(normalView: Value, roughness: Value) -> Value:
    """A and B: what stands by f0, and what is added, (…, 2).

    >>> factors(0.5, 0.0).round(6).tolist()
    [[0.96875, 0.03125]]
    """
    view, half = vec3(sqrt(1.0 - normalView * normalView), 0.0, normalView), halfways(roughness)
    upright = swizzle(half, "z")
    view_half = max(dot(view, half), 0.0)
    light = max(2.0 * view_half * upright - normalView, 0.0)
    weight = shadowing_under_sky(light, roughness) * view_half / upright
    grazing = 1.0 - view_half
    fresnel = grazing * grazing * (grazing * grazing) * grazing
    total = added(weight * vec2(1.0 - fresnel, fresnel))
    return shadowing_under_sky(normalView, roughness) / normalView / float(SAMPLES) * total


def added(parts: Value) -> Value:
    """The sum of what all points give, (SAMPLES, …), one after the other.

    >>> added(np.ones((SAMPLES, 1))).tolist()
    [32.0]
    """
    return reduce(add, (parts[k] for k in range(SAMPLES)), 0.0)
