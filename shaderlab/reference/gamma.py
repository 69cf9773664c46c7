"""Gamma: transfer curves between linear light and encoded display values.

Source: IEC 61966-2-1:1999, "Default RGB colour space – sRGB", section 5.2, with the constants as
OpenGL 3.3 core prints them (sections 3.8.16 and 4.1.8).
"""

from __future__ import annotations

from shaderlab.glslmath import Value, pow, where


def gamma_encode(linear: Value, gamma: Value) -> Value:
    """c^(1/γ): a pure power curve.

    Args:
        linear: light, above 0 (GLSL leaves pow(0, y) open) up to 1.
        gamma: γ, 2.2 for a display that is described by one number.

    Returns the encoded value in 0…1.

    >>> print(f"{gamma_encode(0.5, 2.2).item():.6f}")
    0.729740
    """
    return pow(linear, 1.0 / gamma)


def srgb_encode(linear: Value) -> Value:
    """From light to sRGB: 12.92·c up to 0.0031308, then 1.055·c^(1/2.4) − 0.055.

    Takes light, above 0 up to 1; returns the encoded value in 0…1.

    >>> print(f"{srgb_encode(0.5).item():.6f}")
    0.735357
    """
    straight = 12.92 * linear
    curved = 1.055 * pow(linear, 1.0 / 2.4) - 0.055
    return where(linear <= 0.0031308, straight, curved)


def srgb_decode(encoded: Value) -> Value:
    """From sRGB back to light: c/12.92 up to 0.04045, then ((c + 0.055)/1.055)^2.4.

    Takes the encoded value in 0…1; returns light in 0…1.

    >>> print(f"{srgb_decode(128.0 / 255.0).item():.6f}")
    0.215861
    """
    straight = encoded / 12.92
    curved = pow((encoded + 0.055) / 1.055, 2.4)
    return where(encoded <= 0.04045, straight, curved)
