"""Light maps: the precomputed irradiance of a lamp on a flat wall.

Source: J. H. Lambert, "Photometria", 1760 (the cosine and the inverse square). M. Abrash,
"Graphics Programming Black Book", 1997, chapter 68, describes light maps as Quake has them.
"""

from __future__ import annotations

from ..glslmath import Value, dot, sqrt, swizzle


def baked(place: Value, lamp: Value, intensity: Value) -> Value:
    """The irradiance E = I·cos θ / r² = I·h / (d² + h²)^(3/2) at a place of the plane z = 0.

    Args:
        place: (…, 2), on the wall.
        lamp: (…, 3); its last component h is how far in front of the wall it hangs, h > 0.
        intensity: I, a number or one for each channel.

    Returns (…, 1) or (…, 3), in the intensity's unit over a length squared.

    >>> float(baked(np.array([3.0, 0.0]), np.array([0.0, 0.0, 4.0]), 1.0)[0])
    0.032
    """
    aside = place - swizzle(lamp, "xy")
    height = swizzle(lamp, "z")
    squared = dot(aside, aside) + height * height
    return intensity * height / (squared * sqrt(squared))
