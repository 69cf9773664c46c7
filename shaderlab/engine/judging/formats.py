"""What bands and references become in an attachment of some format."""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands import Allowed, Band, Integer, Rules
from shaderlab.bands.formats import srgb_encode
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array

FLOAT_FORMATS = ("r32f", "rg32f", "rgba32f")
_UNORM_FORMATS = ("r8", "rg8", "rgb8", "rgba8")


INTEGER_FORMATS = tuple(f"{c}32{kind}" for c in ("r", "rg", "rgba") for kind in ("i", "ui"))


def as_result(value: Any, format: str, rules: Rules) -> Band | Integer:
    """What a formula gives, as an attachment of this format takes it: GLSL converts integers to
    floats by itself, and not back."""
    if format in INTEGER_FORMATS:
        whole = Integer(0, unsigned=format.endswith("ui"), rules=rules).lift(value)
        if whole is not None:
            return whole
    return Band.exact(0.0, rules).lift(value)


def stored(band: Band | Integer, format: str, components: int) -> Band | Allowed:
    """What may come back from an attachment of this format.

    Raises:
        FormulaError: a formula of floats for integers, or the other way round.
    """
    if format in INTEGER_FORMATS:
        return _stored_integers(band, format)
    assert isinstance(band, Band)
    if format in FLOAT_FORMATS:
        return band
    if format.startswith("depth"):
        return band.quantise(format.removesuffix("_stencil8"))
    if format.endswith("16f"):
        return band.quantise("rgba16f")
    if format in _UNORM_FORMATS:
        return band.quantise("rgba8")
    if format != "srgb8_alpha8":
        raise FormulaError(f"no formula can be judged over a {format} attachment")
    color, alpha = band.quantise("srgb8"), band.quantise("rgba8")
    # Alpha is not encoded (OpenGL 4.5, §17.3.7): the last component keeps its own rule.
    is_alpha = np.arange(components) == 3
    names = ("lo", "hi", "nan", "vacuous", "undecided")
    picked = {n: np.where(is_alpha, getattr(alpha, n), getattr(color, n)) for n in names}
    return Allowed(**picked, unit=1.0)


def _stored_integers(whole: Band | Integer, format: str) -> Allowed:
    unsigned = format.endswith("ui")
    if not isinstance(whole, Integer) or whole.unsigned != unsigned:
        number, vector = ("uint", "uvec2") if unsigned else ("int", "ivec2")
        raise FormulaError(
            f"gives {whole!r}, the attachment holds {format}",
            remedy=f"use glslmath.{number}(…), or {vector}(…) and its like",
        )
    nowhere = np.zeros(whole.shape, np.bool_)
    anything = np.broadcast_to(whole.anything, whole.shape)
    low, high = whole.lo.astype(np.float64), whole.hi.astype(np.float64)
    return Allowed(low, high, nowhere, anything, nowhere, unit=1.0)


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
