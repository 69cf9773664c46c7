"""Tone mapping: from unbounded light to a display's range 0…1.

Sources: E. Reinhard, M. Stark, P. Shirley, J. Ferwerda, "Photographic Tone Reproduction for
Digital Images", ACM Transactions on Graphics 21(3), 2002, equation 3; J. de Vries, "Learn OpenGL"
(2020), chapter "HDR" (the exponential curve, which is how a film emulsion saturates).
"""

from __future__ import annotations

from shaderlab.glslmath import Value, exp, min


def clipped(light: Value) -> Value:
    """Clipping, as an 8-bit framebuffer does: everything above 1 becomes 1.

    >>> clipped(12.5).item()
    1.0
    """
    return min(light, 1.0)


def reinhard(light: Value) -> Value:
    """x / (1 + x): dark tones hardly change, bright ones stay below 1.

    Takes light x ≥ 0, of any size; returns 0…1, 1 not included.

    >>> reinhard(3.0)
    0.75
    """
    return light / (1.0 + light)


def exposed(light: Value, exposure: Value) -> Value:
    """1 − exp(−x·e): film exposed for longer or shorter.

    Args:
        light: x ≥ 0.
        exposure: e > 0; twice the exposure is twice the light.

    >>> print(f"{exposed(1.0, 1.0).item():.6f}")
    0.632121
    """
    return 1.0 - exp(-light * exposure)
