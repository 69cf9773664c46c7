"""Blending: how a fragment is mixed with what the framebuffer holds already.

Source: T. Porter, T. Duff, "Compositing Digital Images", SIGGRAPH 1984 (the operator *over*); as
a blend function in "The OpenGL Graphics System: A Specification", version 3.3 core, section 4.1.7.
"""

from __future__ import annotations

from shaderlab.glslmath import Value, swizzle


def over(source: Value, destination: Value) -> Value:
    """source·α + destination·(1 − α), with GL_SRC_ALPHA and GL_ONE_MINUS_SRC_ALPHA.

    All four channels get the same factors, the alpha channel too: it becomes α² + (1 − α)·Ad.

    Args:
        source: the fragment's colour and α, (…, 4).
        destination: the colour and alpha it falls on, (…, 4).

    >>> import numpy as np
    >>> green, red = np.array([0.0, 1.0, 0.0, 0.6]), np.array([1.0, 0.0, 0.0, 1.0])
    >>> over(green, red).round(6).tolist()
    [0.4, 0.6, 0.0, 0.76]
    """
    alpha = swizzle(source, "w")
    return source * alpha + destination * (1.0 - alpha)
