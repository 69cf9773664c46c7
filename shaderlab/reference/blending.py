"""Blending: combining a fragment with the framebuffer's colour.

Source: T. Porter, T. Duff, "Compositing Digital Images", SIGGRAPH 1984 (the operator *over*); as
a blend function in "The OpenGL Graphics System: A Specification", version 3.3 core, section 4.1.7
(equations of table 4.1, factors of table 4.2).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from shaderlab.glslmath import Value, swizzle


def over(source: Value, destination: Value) -> Value:
    """source·α + destination·(1 − α), with GL_SRC_ALPHA and GL_ONE_MINUS_SRC_ALPHA.

    All four channels get the same factors, the alpha channel too: it becomes α² + (1 − α)·Ad.

    Args:
        source: the fragment's colour and α, (…, 4).
        destination: the colour and alpha it falls on, (…, 4).

    >>> green, red = np.array([0.0, 1.0, 0.0, 0.6]), np.array([1.0, 0.0, 0.0, 1.0])
    >>> over(green, red).round(6).tolist()
    [0.4, 0.6, 0.0, 0.76]
    """
    alpha = swizzle(source, "w")
    return source * alpha + destination * (1.0 - alpha)


Color = npt.NDArray[np.float64]

FACTORS: Mapping[str, Callable[[Color, Color, Color], Color]] = {
    "zero": lambda s, d, c: np.zeros(4),
    "one": lambda s, d, c: np.ones(4),
    "src_color": lambda s, d, c: s,
    "one_minus_src_color": lambda s, d, c: 1.0 - s,
    "dst_color": lambda s, d, c: d,
    "one_minus_dst_color": lambda s, d, c: 1.0 - d,
    "src_alpha": lambda s, d, c: np.full(4, s[3]),
    "one_minus_src_alpha": lambda s, d, c: 1.0 - np.full(4, s[3]),
    "dst_alpha": lambda s, d, c: np.full(4, d[3]),
    "one_minus_dst_alpha": lambda s, d, c: 1.0 - np.full(4, d[3]),
    "constant_color": lambda s, d, c: c,
    "one_minus_constant_color": lambda s, d, c: 1.0 - c,
    "constant_alpha": lambda s, d, c: np.full(4, c[3]),
    "one_minus_constant_alpha": lambda s, d, c: 1.0 - np.full(4, c[3]),
    "src_alpha_saturate": lambda s, d, c: np.array([*[min(s[3], 1.0 - d[3])] * 3, 1.0]),
}
"""Table 4.2: each factor's four channels, from source, destination and the blend constant."""

EQUATIONS: Mapping[str, Callable[[Color, Color, Color, Color], Color]] = {
    "add": lambda s, f, d, g: s * f + d * g,
    "subtract": lambda s, f, d, g: s * f - d * g,
    "reverse_subtract": lambda s, f, d, g: d * g - s * f,
    "min": lambda s, f, d, g: np.minimum(s, d),
    "max": lambda s, f, d, g: np.maximum(s, d),
}
"""Table 4.1: how weighted source and destination are combined; MIN and MAX ignore the weights."""


def blended(
    equation: str,
    factors: tuple[str, str],
    source: Sequence[float],
    destination: Sequence[float],
    constant: Sequence[float],
) -> Color:
    """A floating-point framebuffer's colour after a fragment, with one equation for all channels.

    Args:
        equation: a name of `EQUATIONS`.
        factors: names of `FACTORS`, the source's and the destination's.
        source, destination, constant: red, green, blue and alpha.

    >>> green, red, none = (0.0, 1.0, 0.0, 0.6), (1.0, 0.0, 0.0, 1.0), (0.0,) * 4
    >>> blended("add", ("src_alpha", "one_minus_src_alpha"), green, red, none).round(6).tolist()
    [0.4, 0.6, 0.0, 0.76]
    >>> blended("max", ("zero", "zero"), green, red, none).tolist()
    [1.0, 1.0, 0.0, 1.0]
    """
    s, d, c = (np.asarray(v, np.float64) for v in (source, destination, constant))
    f, g = (FACTORS[name](s, d, c) for name in factors)
    return EQUATIONS[equation](s, f, d, g)
