"""The numbers behind a check's pictures, compressed so that a page can embed all of them.

A file is one zlib stream: a line of JSON (`Values` but for its arrays), then, each for all
components one after the other, rows from the bottom:

    flags      1 byte a value: 1 was judged, 2 lies outside its band
    measured   float32 as ordered integers, less the value to the left (the first: below)
    reference  ordered integer of the nearest float32, less the measured one
    low        ordered integers, less the reference's
    high       minus ordered integers plus the reference's, less `low`: bands are nearly symmetric

Ordered integers follow the order of floats one ULP a step (the sign bit's complement for negative
ones); 32-bit ones wrap around, are folded so that small ones of either sign have zero bytes, and
stand byte by byte, all lowest bytes first. Measured values are usually a few ULP from their
reference, so most of those bytes are zero.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .files import deflate

Numbers = NDArray[Any]
# Pictures with more pixels than a square of this side, at four components, are cut to such a
# square around their worst value.
WINDOW = 64


@dataclass(frozen=True, kw_only=True)
class Values:
    """The judged part of a picture, all arrays (rows, columns, components), row 0 the lowest.

    Attributes:
        size: (width, height) of the whole picture.
        origin: (x, y) of the arrays' first value in it.
        unit: size of one code of a fixed-point format; 0 for floats, whose unit is the ULP.
        whole: whether all judged values are here.
        measured, reference, low, high: as float32 holds them.
        judged, outside: booleans; the other arrays mean something only where `judged` is true.
    """

    size: tuple[int, int]
    origin: tuple[int, int]
    unit: float
    whole: bool
    measured: Numbers
    reference: Numbers
    low: Numbers
    high: Numbers
    judged: NDArray[np.bool_]
    outside: NDArray[np.bool_]

    def corner(self) -> "Values":
        """The lowest values at the left, a quarter of a whole window at most."""
        side = WINDOW // 2
        if self.measured.size <= 4 * side**2:
            return self
        named = ("measured", "reference", "low", "high", "judged", "outside")
        part = {name: getattr(self, name)[:side, :side] for name in named}
        return replace(self, whole=False, **part)


def pack(values: "Values") -> bytes:
    """The values as a file's bytes; `report/script/values.js` reads them."""
    columns = _to_columns(values)
    rows, width, components = values.measured.shape
    head = {
        "size": values.size,
        "origin": values.origin,
        "columns": width,
        "rows": rows,
        "components": components,
        "unit": values.unit,
        "whole": values.whole,
    }
    text = json.dumps(head, separators=(",", ":")) + "\n"
    return deflate(b"".join((text.encode("ascii"), *columns)))


def judged_part(arrays: Mapping[str, Any], worst: tuple[int, int] | None = None) -> "Values":
    """The smallest part of a check's pictures that holds all judged values.

    Args:
        arrays: of shape (height, width, components): "measured", "exact", "low", "high" and
            "outside", or functions as of `Judgement`; "covered" (height, width), and "unit". Of an
            exact comparison "measured" and "reference" alone: each band is its reference. Only the
            part is looked at.
        worst: (x, y) of the value to keep where the picture is too large to be kept whole.
    """
    height, width, components = arrays["measured"].shape
    covered = arrays.get("covered", np.True_)
    covered = np.broadcast_to(covered, (height, width))
    ys, xs = (np.flatnonzero(covered.any(axis=axis)) for axis in (1, 0))
    box = [(int(a[0]), int(a[-1]) + 1) if a.size else (0, 1) for a in (xs, ys)]
    whole = (box[0][1] - box[0][0]) * (box[1][1] - box[1][0]) * components <= 4 * WINDOW**2
    if not whole:
        centre = worst or (box[0][0], box[1][0])
        box = [_window(*ends, at) for ends, at in zip(box, centre, strict=True)]
    part = slice(*box[1]), slice(*box[0])
    measured = arrays["measured"][part]
    if "exact" in arrays:
        pixels = (np.cumsum(covered) - 1).reshape(covered.shape)[part][covered[part]]

        def take(name: str) -> Numbers:
            if not callable(arrays[name]):
                return arrays[name][part]  # type: ignore[no-any-return]
            numbers = arrays[name](pixels)
            full = np.zeros(measured.shape, numbers.dtype)
            full[covered[part]] = numbers
            return full

        reference, low, high, outside = map(take, ("exact", "low", "high", "outside"))
        unit = float(arrays["unit"])
    else:
        low = high = reference = arrays["reference"][part]
        outside = (measured != reference) & ~(np.isnan(measured) & np.isnan(reference))
        unit = float(arrays["measured"].dtype.kind in "iu")
    return Values(
        size=(width, height),
        origin=(box[0][0], box[1][0]),
        unit=unit,
        whole=whole,
        measured=measured,
        reference=reference,
        low=low,
        high=high,
        judged=np.broadcast_to(covered[part][..., None], measured.shape),
        outside=outside,
    )


def _window(start: int, stop: int, centre: int) -> tuple[int, int]:
    low = max(start, min(centre - WINDOW // 2, stop - WINDOW))
    return low, min(stop, low + WINDOW)


def _to_columns(values: "Values") -> list[bytes]:
    judged = np.moveaxis(values.judged, -1, 0)
    planes = np.empty((4, *judged.shape), np.float32)
    arrays = values.measured, values.reference, values.low, values.high
    with np.errstate(invalid="ignore", over="ignore"):
        for plane, array in zip(planes, arrays, strict=True):
            plane[...] = np.moveaxis(array, -1, 0)
    if not values.judged.all():
        planes[:, ~judged] = 0.0
    measured, nearest, low, high = _to_ordered(planes)
    steps, away, below, above = columns = np.empty_like(planes, np.int32)
    steps[...] = measured
    steps[:, :, 1:] -= measured[:, :, :-1]
    steps[:, 1:, 0] -= measured[:, :-1, 0]
    np.subtract(nearest, measured, out=away)
    np.subtract(low, nearest, out=below)
    np.subtract(nearest, high, out=above)
    above -= below
    signs = columns >> 31
    columns <<= 1
    columns ^= signs
    flags = judged.astype(np.uint8)
    flags += np.moveaxis(values.outside, -1, 0).astype(np.uint8) << 1
    return [flags.tobytes(), *map(_split_bytes, columns)]


def _to_ordered(values: NDArray[np.float32]) -> NDArray[np.int32]:
    bits = values.view(np.int32)
    return bits ^ ((bits >> 31) & np.int32(0x7FFFFFFF))


def _split_bytes(numbers: NDArray[Any]) -> bytes:
    shifts = range(0, 8 * numbers.itemsize, 8)
    return b"".join((numbers >> shift).astype(np.uint8).tobytes() for shift in shifts)
