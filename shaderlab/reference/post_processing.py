"""Post-processing: grey values, the inverse, and 3 × 3 kernels.

Sources: ITU-R Recommendation BT.709-6, "Parameter values for the HDTV standards", 2015, item 3.2
(luminance coefficients .2126, .7152, .0722); R. C. Gonzalez and R. E. Woods, "Digital Image
Processing", 4th ed., 2018, eq. 3-31 (filtering by a kernel) and table 3.6.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.glslmath import Value, dot, swizzle, vec3

Array = npt.NDArray[Any]

SHARPEN = (0.0, -1.0, 0.0, -1.0, 5.0, -1.0, 0.0, -1.0, 0.0)
BLUR = tuple(w / 16.0 for w in (1, 2, 1, 2, 4, 2, 1, 2, 1))
EDGES = (1.0, 1.0, 1.0, 1.0, -8.0, 1.0, 1.0, 1.0, 1.0)
EMBOSS = (-1.0, -1.0, 0.0, -2.0, 1.0, 2.0, 0.0, 1.0, 1.0)
"""Kernels row by row, the uppermost first."""


def average(color: Value) -> Value:
    """The mean of red, green and blue, (…, 1).

    >>> average(np.array([1.0, 0.5, 0.31])).round(6).tolist()
    [0.603333]
    """
    return (swizzle(color, "x") + swizzle(color, "y") + swizzle(color, "z")) / 3.0


def luminance(color: Value) -> Value:
    """The relative luminance of a linear colour with Rec. 709 primaries, (…, 1).

    >>> luminance(np.array([1.0, 0.5, 0.31])).round(6).tolist()
    [0.592582]
    """
    return dot(color, vec3(0.2126, 0.7152, 0.0722))


def inverse(color: Value) -> Value:
    """The inverse: 1 − colour.

    >>> inverse(0.25)
    0.75
    """
    return 1.0 - color


def filtered(neighbours: Sequence[Value], kernel: Sequence[Value]) -> Value:
    """The weighted sum of nine neighbours, row by row, the uppermost first.

    >>> filtered([1.0] * 9, EDGES)
    0.0
    """
    total: Value = kernel[0] * neighbours[0]
    for weight, color in zip(kernel[1:], neighbours[1:], strict=True):
        total = total + weight * color
    return total


def convolved(image: Array, kernel: Sequence[float]) -> Array:
    """A whole image filtered by a kernel, its edges replicated, by NumPy's convolution.

    Convolution flips a kernel; flipped beforehand, it lies over the image as it is printed. Rows
    are convolved one at a time.

    Args:
        image: (height, width, channels), row 0 the lowest.
        kernel: nine weights, the uppermost row first.

    >>> spot = np.zeros((3, 3, 1)); spot[1, 1] = 1.0
    >>> convolved(spot, range(9))[::-1, :, 0].astype(int).tolist()
    [[8, 7, 6], [5, 4, 3], [2, 1, 0]]
    """
    weights = np.reshape(np.asarray(kernel, float), (3, 3))[::-1]
    padded = np.pad(np.asarray(image, float), ((1, 1), (1, 1), (0, 0)), mode="edge")
    result = np.zeros(image.shape)
    for row in range(image.shape[0]):
        for channel in range(image.shape[2]):
            result[row, :, channel] = sum(
                np.convolve(padded[row + k, :, channel], weights[k][::-1], mode="valid")
                for k in range(3)
            )
    return result
