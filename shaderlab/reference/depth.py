"""Window depth, the distance it encodes, and its resolution.

Source: "The OpenGL Graphics System: A Specification", version 3.3 core (M. Segal, K. Akeley,
2010), section 2.13.1 (window z from clip coordinates), with the projection matrix of version 1.0,
section 2.9.2 (glFrustum); the form below is J. de Vries, "Learn OpenGL" (2020), chapter "Depth
testing": F_depth = (1/z − 1/n) / (1/f − 1/n).

All distances z are positive, along the view direction, in units of the scene: 0 < n ≤ z ≤ f.
"""

from __future__ import annotations

import numpy as np

from ..glslmath import Value


def window_depth(distance: Value, near: Value, far: Value) -> Value:
    """F_depth: the depth buffer's value, 0 at the near plane and 1 at the far one.

    Args:
        distance: z, n ≤ z ≤ f.
        near, far: n and f, 0 < n < f.

    Returns 0…1; half of it lies before z = 2·n·f / (n + f).

    >>> print(f"{window_depth(2.0, 1.0, 100.0):.6f} {window_depth(2.0, 0.1, 100.0):.6f}")
    0.505051 0.950951
    """
    return (1.0 / distance - 1.0 / near) / (1.0 / far - 1.0 / near)


def distance_of(depth: Value, near: Value, far: Value) -> Value:
    """The inverse of `window_depth`: 2·n·f / (f + n − d·(f − n)), d = 2·depth − 1 being z in
    normalised device coordinates.

    Args:
        depth: the depth buffer's value, 0…1.
        near, far: as in `window_depth`.

    Returns z, n…f.

    >>> print(f"{distance_of(0.5, 1.0, 100.0):.6f}")
    1.980198
    """
    ndc = 2.0 * depth - 1.0
    return 2.0 * near * far / (far + near - ndc * (far - near))


def linear_depth(distance: Value, near: Value, far: Value) -> Value:
    """Depth as a linear function of z: (z − n) / (f − n).

    >>> print(f"{linear_depth(50.5, 1.0, 100.0):.6f}")
    0.500000
    """
    return (distance - near) / (far - near)


def depth_step(distance: Value, near: Value, far: Value, bits: int = 24) -> Value:
    """The least distance at z between surfaces that a fixed-point depth buffer tells apart:
    z²·(1/n − 1/f) / 2^bits, one code over the slope of `window_depth`.

    Args:
        distance: z, n ≤ z ≤ f.
        near, far: as in `window_depth`.
        bits: of the depth buffer, 16 or 24.

    Returns a distance in units of the scene.

    >>> print(f"{depth_step(50.0, 0.1, 100.0):.8f} {depth_step(50.0, 1.0, 100.0):.9f}")
    0.00148863 0.000147521
    """
    return distance * distance * (1.0 / near - 1.0 / far) / 2.0**bits


def same_code_share(
    gap: float, middle: float, slant: float, near: float, far: float, bits: int
) -> float:
    """The share of a slanted wall's pixels with the same depth code as a wall `gap` behind it.

    Two depths ΔF apart have the same code with the probability 1 − ΔF·2^bits, or never; the wall
    runs from middle − slant to middle + slant, evenly over the screen in 1/z.

    Args:
        gap: along the view direction, 0 or more (less: the order is reversed, and all are wrong).
        middle, slant: distances, slant < middle.
        near, far, bits: as in `depth_step`.

    >>> round(same_code_share(0.0763, 10.0, 1.0, 0.01, 100.0, 16), 2)
    0.49
    """
    start, stop = (float(window_depth(z, near, far)) for z in (middle - slant, middle + slant))
    across = np.linspace(start, stop, 2001)
    behind = window_depth(distance_of(across, near, far) + gap, near, far)
    codes = (behind - across) * 2.0**bits
    return float(np.clip(1.0 - codes, 0.0, 1.0).mean())
