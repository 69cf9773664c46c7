"""What bands and references become in an attachment of some format."""

from __future__ import annotations

import numpy as np

from shaderlab.bands import Allowed, Band
from shaderlab.bands.formats import srgb_encode
from shaderlab.errors import FormulaError
from shaderlab.frame import Array

FLOAT_FORMATS = ("r32f", "rg32f", "rgba32f")
_UNORM_FORMATS = ("r8", "rg8", "rgb8", "rgba8")


def stored(band: Band, format: str, components: int) -> Band | Allowed:
    """The band as it may come back from an attachment of this format."""
    if format in FLOAT_FORMATS:
        return band
    if format.startswith("depth"):
        return band.quantise(format.removesuffix("_stencil8"))
    if format.endswith("16f"):
        return band.quantise("rgba16f")
    if format in _UNORM_FORMATS:
        return band.quantise("rgba8")
    if format != "srgb8_alpha8":
        raise FormulaError(f"a formula over a {format} attachment: judge integers with exact(…)")
    color, alpha = band.quantise("srgb8"), band.quantise("rgba8")
    # Alpha is not encoded (OpenGL 4.5, §17.3.7): the last component keeps its own rule.
    is_alpha = np.arange(components) == 3
    names = ("lo", "hi", "nan", "vacuous", "undecided")
    picked = {n: np.where(is_alpha, getattr(alpha, n), getattr(color, n)) for n in names}
    return Allowed(**picked, unit=1.0)


def in_format(values: Array, format: str) -> Array:
    """A float64 reference as it would be read back from `format`, unrounded."""
    if format in _UNORM_FORMATS:
        return np.clip(values, 0.0, 1.0) * 255.0
    if format.startswith("depth"):
        return np.clip(values, 0.0, 1.0)
    if format == "srgb8_alpha8":
        linear = np.clip(values, 0.0, 1.0)
        encoded = srgb_encode(linear)
        encoded[..., 3:] = linear[..., 3:]
        return encoded * 255.0
    return values
