"""One lookup in a texture, whatever is known of the place: where a band reaches over more texels
than `shaderlab.glslmath.sampling` takes, the answer is any texel."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands import Band, Rules, Truth
from shaderlab.glslmath.sampling import Sampler
from shaderlab.glslmath.sampling.filters import ROUNDING, WEIGHT
from shaderlab.glslmath.sampling.functions import sampled
from shaderlab.glslmath.sampling.reading import level_values, stored
from shaderlab.glslmath.sampling.spans import Span, span_of

from ..memory import Flags
from ..values import select

if TYPE_CHECKING:
    from ..running import Run

_CODE = 1.0 / 255.0
# Half a code off (Direct3D 11.3, functional specification, 3.2.3.7), where the curve is steepest.
_SRGB = 0.5 * _CODE * 2.4 / 1.055
_NARROW = 1.0 - 4.0 * WEIGHT  # of a place or a level, in texels or levels


@dataclass(frozen=True)
class Lookup:
    """A sampled texture, the coordinates (then the value to compare), the level of detail or None,
    where that is unknown, and the offset in texels."""

    sampler: Sampler
    place: Any
    level: Span | None
    unknown: Any
    offset: tuple[int, int]


def answer(run: Run, lookup: Lookup, mask: Flags) -> Any:
    """The texture function's value for the invocations of a mask; others may be anywhere."""
    lookup, give = _decoded(lookup)
    rules = lookup.sampler.rules
    ignored = np.zeros(1, np.bool_) if mask.all() else ~mask
    wide = ignored if rules is None else ignored | _wide(lookup)
    found = run.arithmetic.rounded(_sampled(run, lookup, wide))
    if rules is None or not isinstance(found, Band):
        return found
    if give:
        found = Band.between(found.lo - give, found.hi + give, rules)
    unsure = wide & ~ignored
    if unsure.any():
        found = select(Truth(unsure[:, None], ~unsure[:, None]), _any_texel(lookup, rules), found)
    if lookup.unknown is not None and lookup.unknown.any():
        found = found.made(found.lo, found.hi, anything=lookup.unknown[:, None])
    return found


def _decoded(lookup: Lookup) -> tuple[Lookup, float]:
    """The lookup in linear texels, and what OpenGL leaves open about them besides: how precisely
    texels of 8 bits are filtered (llvmpipe does that in 8 bits, too), and sRGB decoded."""
    texels = lookup.sampler.texels
    if texels.values.dtype != np.uint8:
        return lookup, 0.0
    give = _CODE if any("linear" in word for word in texels.filter) else 0.0
    if not texels.format.startswith("srgb"):
        return lookup, give
    linear = replace(
        texels,
        values=_linear(texels.values),
        smaller=tuple(map(_linear, texels.smaller)),
        format="rgba32f",
    )
    return replace(lookup, sampler=replace(lookup.sampler, texels=linear)), give + _SRGB


def _linear(codes: Any) -> Any:
    """sRGB codes as linear values; alpha is linear (OpenGL 4.5, §8.24)."""
    c = codes / 255.0
    decoded = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    decoded[..., 3:] = c[..., 3:]
    return decoded.astype(np.float32)


def _sampled(run: Run, lookup: Lookup, elsewhere: Flags) -> Any:
    """The sample, taken in the middle for the invocations that are left out."""
    place, level = lookup.place, lookup.level
    if elsewhere.any():
        out = elsewhere[:, None]
        middle = run.arithmetic.exact(np.full((1, place.shape[-1]), 0.25))
        place = select(Truth(out, ~out), middle, place)
        if level is not None:
            zeroed = np.where(elsewhere, 0.0, level[0])
            same = level[0] is level[1]
            level = (zeroed, zeroed if same else np.where(elsewhere, 0.0, level[1]))
    return sampled(lookup.sampler, place, level, lookup.offset)


def _wide(lookup: Lookup) -> Flags:
    """Which places or levels are known to less than a texel or a level."""
    low, high = span_of(lookup.place)
    texels = lookup.sampler.texels
    with np.errstate(all="ignore"):
        if texels.kind == "Cube":
            # A component of a unit vector moves the place on a face by half of its size, or more.
            size = level_values(lookup.sampler, 0).shape[1]
            largest = np.maximum(np.abs(low), np.abs(high))[..., :3].max(axis=-1)
            moved = (high - low)[..., :3].max(axis=-1) / largest * size
            wide = ~(moved < _NARROW)
        else:
            depth, height, width, _ = level_values(lookup.sampler, 0).shape
            size = (width, height, depth) if texels.kind == "3D" else (width, height)
            moved = (high - low)[..., : len(size)] * np.array(size)
            wide = ~(moved < _NARROW).all(axis=-1)
        if texels.compare is not None:
            wide = wide | ~np.isfinite(low).all(axis=-1) | ~np.isfinite(high).all(axis=-1)
        if lookup.level is not None:
            # Levels beyond the first and the last one are those.
            ends = (np.clip(end, *texels.lod) for end in lookup.level)
            first, last = (np.clip(end, 0.0, len(texels.smaller)) for end in ends)
            wide = wide | ~(last - first < _NARROW)
    found: Flags = wide
    return found


def _any_texel(lookup: Lookup, rules: Rules) -> Band:
    """Any mix of the texture's texels, (1, 4); of a shadow sampler any answer, (1, 1)."""
    sampler = lookup.sampler
    if sampler.texels.compare is not None:
        return Band.between([[0.0]], [[1.0]], rules)
    border = np.asarray(sampler.texels.border, np.float64)
    lows, highs = [border], [border]
    for level in range(1 + len(sampler.texels.smaller)):
        layers, height, width, _ = level_values(sampler, level).shape
        layer, y, x = (axis.ravel() for axis in np.indices((layers, height, width)))
        low, high = stored(sampler, level, x, y, layer)
        lows.append(low.min(axis=0))
        highs.append(high.max(axis=0))
    low, high = np.minimum.reduce(lows), np.maximum.reduce(highs)
    give = ROUNDING * np.maximum(np.abs(low), np.abs(high))
    return Band.between((low - give)[None], (high + give)[None], rules)
