"""GLSL's hyperbolic functions (GLSL 4.60, 8.1): in bands with the errors of their expansions.

Source: the Vulkan specification (Khronos), "Precision and Operation of SPIR-V Instructions":
sinh, cosh, tanh, asinh, acosh and atanh are "inherited from" exponentials and logarithms.
"""

from __future__ import annotations

import numpy as np

from shaderlab.bands import Band
from shaderlab.glslmath.dispatch import Value, applied, undefined
from shaderlab.glslmath.scalar import exp, log, sqrt


def sinh(x: Value) -> Value:
    """(exp(x) - exp(-x)) · 0.5.

    >>> f"{sinh(1.0):.6f}"
    '1.175201'
    """
    return applied(np.sinh, lambda x: (exp(x) - exp(-x)) * 0.5, x)


def cosh(x: Value) -> Value:
    """(exp(x) + exp(-x)) · 0.5.

    >>> f"{cosh(1.0):.6f}"
    '1.543081'
    """
    return applied(np.cosh, lambda x: (exp(x) + exp(-x)) * 0.5, x)


def tanh(x: Value) -> Value:
    """sinh(x) / cosh(x).

    >>> f"{tanh(1.0):.6f}"
    '0.761594'
    """
    return applied(np.tanh, lambda x: sinh(x) / cosh(x), x)


def asinh(x: Value) -> Value:
    """log(x + √(x·x + 1)); large errors are allowed where x is far below 0.

    >>> f"{asinh(1.0):.6f}"
    '0.881374'
    """
    return applied(np.arcsinh, lambda x: log(x + sqrt(x * x + 1.0)), x)


def acosh(x: Value) -> Value:
    """log(x + √(x·x - 1)); undefined for x < 1.

    >>> f"{acosh(2.0):.6f}"
    '1.316958'
    """

    def banded(x: Band) -> Band:
        return undefined(log(x + sqrt(x * x - 1.0)), x.lo < 1.0)

    return applied(np.arccosh, banded, x)


def atanh(x: Value) -> Value:
    """log((1 + x) / (1 - x)) · 0.5; undefined for |x| ≥ 1.

    >>> f"{atanh(0.5):.6f}"
    '0.549306'
    """

    def banded(x: Band) -> Band:
        found = log((1.0 + x) / (1.0 - x)) * 0.5
        return undefined(found, (x.lo <= -1.0) | (x.hi >= 1.0))

    return applied(np.arctanh, banded, x)
