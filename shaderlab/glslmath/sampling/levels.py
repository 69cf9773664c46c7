"""Mipmap levels: which levels a sample reads, and how two of them are mixed.

Source: OpenGL 4.5 core profile specification, §8.14.3 (equations 8.18 to 8.22) and §8.15 (where
minification ends: at a level of 0, or of 0.5 for some pairs of filters, at the driver's choice).
Direct3D 11.3 (functional specification, §7.18.10) asks for 8 bits of fraction in the level.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array

from .filters import ROUNDING, WEIGHT, corners
from .reading import Sampler
from .spans import Span, hull, require_narrow, widened

Filtered = Callable[[int, str], Span]
"""A sample of one level, filtered "nearest" or "linear"."""


def at_level(sampler: Sampler, filtered: Filtered, lod: Span | None) -> Span:
    """A sample at a level of detail: magnified, minified from one level, or a mix of two levels.

    Raises:
        FormulaError: the filters depend on a level, and it is None.
    """
    texels = sampler.texels
    minify, magnify = texels.filter
    within, _, between = minify.partition("_mipmap_")
    if minify == magnify:
        return filtered(0, magnify)
    if lod is None:
        raise FormulaError(
            f"texture(): with the filters {texels.filter} a sample depends on the mipmap level",
            remedy="give it as lod= (the logarithm of texels a pixel), or sample with textureLod",
        )
    low, high = (np.clip(bound, *texels.lod) for bound in lod)
    latest = 0.0
    if sampler.rules is not None and between and within == "nearest" and magnify == "linear":
        latest = 0.5
    magnified, minified = low <= latest, high > 0.0
    parts: list[tuple[Any, Span]] = []
    if magnified.any():
        parts.append((magnified, filtered(0, magnify)))
    if minified.any():
        parts.append((minified, _minified(sampler, filtered, within, between, (low, high))))
    result_low: Any = np.inf
    result_high: Any = -np.inf
    if len(parts) == 1 and parts[0][0].all():
        result_low, result_high = parts.pop()[1]
    for may, (part_low, part_high) in parts:
        result_low = np.where(may[..., None], np.minimum(result_low, part_low), result_low)
        result_high = np.where(may[..., None], np.maximum(result_high, part_high), result_high)
    if sampler.rules is not None and "linear" in {within, magnify}:
        return widened((result_low, result_high), ROUNDING * _largest(sampler))
    return result_low, result_high


def _largest(sampler: Sampler) -> float:
    """The greatest number that a sample can mix. Where the filter changes from pixel to pixel,
    drivers run NEAREST as a mix, too, with weights of 0 and 1 (llvmpipe does): its roundings stay.
    """
    texels = sampler.texels
    if texels.compare is not None or texels.values.dtype == np.uint8:
        return 1.0
    numbers = [np.abs(level).max() for level in (texels.values, *texels.smaller)]
    return float(max(*numbers, *(abs(value) for value in texels.border)))


def _minified(sampler: Sampler, filtered: Filtered, within: str, between: str, lod: Span) -> Span:
    last = len(sampler.texels.smaller)
    if not between:
        return filtered(0, within)
    lod = np.clip(lod[0], 0.0, last), np.clip(lod[1], 0.0, last)
    if between == "nearest":
        # Between two levels either: the specification's rounding, or the floor of one half more.
        ends = [np.ceil(lod[0] + 0.5) - 1.0, np.floor(lod[1] + 0.5)]
        chosen = [np.clip(end, 0, last) for end in ends[: 1 if sampler.rules is None else 2]]
        require_narrow((chosen[0], chosen[-1]), "texture(), the level")
        known = _levels(filtered, within, chosen)
        return hull([_picked(known, number) for number in chosen])
    exact = sampler.rules is None
    place = lod if exact else widened(lod, WEIGHT)
    require_narrow(place, "texture(), the level")
    low, high = np.clip(place[0], 0, last), np.clip(place[1], 0, last)
    ends = [low] if exact else corners((low, high))
    below = [np.minimum(np.floor(end), max(last - 1, 0)) for end in ends]
    known = _levels(filtered, within, [*below, *(np.minimum(b + 1, last) for b in below)])
    return hull(
        [_between(known, b, np.minimum(b + 1, last), e - b, exact)
         for b, e in zip(below, ends, strict=True)]
    )  # fmt: skip


def _levels(filtered: Filtered, within: str, numbers: list[Array]) -> dict[int, Span]:
    """The samples of every level that some value reads."""
    wanted = sorted({int(n) for number in numbers for n in np.unique(number)})
    return {number: filtered(number, within) for number in wanted}


def _picked(known: dict[int, Span], number: Array) -> Span:
    """For each value, the sample of the level it reads."""
    low: Any = np.nan
    high: Any = np.nan
    for level, (one, other) in known.items():
        here = (number == level)[..., None]
        low, high = np.where(here, one, low), np.where(here, other, high)
    return low, high


def _between(known: dict[int, Span], one: Array, other: Array, part: Array, exact: bool) -> Span:
    near, far = _picked(known, one), _picked(known, other)
    share = np.clip(part, 0.0, 1.0)[..., None]
    low, high = (a * (1.0 - share) + b * share for a, b in zip(near, far, strict=True))
    if exact:
        return low, high
    size = np.maximum.reduce([np.abs(bound) for span in (near, far) for bound in span])
    return low - ROUNDING * size, high + ROUNDING * size
