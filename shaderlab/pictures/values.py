"""The numbers behind a check's pictures, compressed so that a page can embed all of them.

A file is one zlib stream: a line of JSON (`Values` but for its arrays), then, each for all
components one after the other, rows from the bottom:

    flags      1 byte a value: 1 was judged, 2 lies outside its band
    measured   float32 as ordered integers, less the value to the left (the first: below)
    reference  ordered integer of the nearest float32, less the measured one
    rest       16 bits: what is left of the float64 reference, in 1/65535 of its float32 ULP;
               where nothing is outside in multiples of 2048 of that, which pack well
    low        ordered integers, less the reference's
    high       minus ordered integers plus the reference's, less `low`: bands are nearly symmetric

Ordered integers follow the order of floats one ULP a step (the sign bit's complement for negative
ones); 32-bit ones wrap around, are folded so that small ones of either sign have zero bytes, and
stand byte by byte, all lowest bytes first. Measured values are usually a few ULP from their
reference, so most of those bytes are zero.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shaderlab.lazy_dataclass import dataclass
from shaderlab.pictures.deflate import deflated

Floats = NDArray[np.float64]
_REST = 65535.0
_COARSE = 2048
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
        measured, low, high: as float32 holds them.
        reference: to 40 bits or better where a value is outside, to 29 otherwise.
        judged, outside: booleans; the other arrays mean something only where `judged` is true.
    """

    size: tuple[int, int]
    origin: tuple[int, int]
    unit: float
    whole: bool
    measured: Floats
    reference: Floats
    low: Floats
    high: Floats
    judged: NDArray[np.bool_]
    outside: NDArray[np.bool_]

    @property
    def fine(self) -> bool:
        """Whether references are kept to more than the eight digits that a passing check shows."""
        return bool(self.outside.any())


def pack(values: Values) -> bytes:
    """The values as a file's bytes; `report/script/values.js` reads them."""
    columns = _columns(values)
    rows, width, components = values.measured.shape
    head = {
        "size": values.size,
        "origin": values.origin,
        "columns": width,
        "rows": rows,
        "components": components,
        "unit": values.unit,
        "whole": values.whole,
        "fine": values.fine,
    }
    text = json.dumps(head, separators=(",", ":")) + "\n"
    return deflated(b"".join((text.encode("ascii"), *columns)))


def judged_part(
    arrays: Mapping[str, Any], worst: tuple[int, int] | None = None, window: int = WINDOW
) -> Values:
    """The smallest part of a check's pictures that holds all judged values.

    Args:
        arrays: of shape (height, width, components): "measured", "exact", "low", "high" and
            "outside"; "covered" (height, width), and "unit". Of an exact comparison "measured" and
            "reference" alone: each band is its reference. Only the part is looked at.
        worst: (x, y) of the value to keep where the picture is too large to be kept whole.
        window: how many pixels of it are kept then in each direction.
    """
    height, width, components = arrays["measured"].shape
    covered = arrays.get("covered", np.True_)
    covered = np.broadcast_to(covered, (height, width))
    ys, xs = (np.flatnonzero(covered.any(axis=axis)) for axis in (1, 0))
    box = [(int(a[0]), int(a[-1]) + 1) if a.size else (0, 1) for a in (xs, ys)]
    whole = (box[0][1] - box[0][0]) * (box[1][1] - box[1][0]) * components <= 4 * window**2
    if not whole:
        centre = worst or (box[0][0], box[1][0])
        box = [_window(*ends, at, window) for ends, at in zip(box, centre, strict=True)]
    part = slice(*box[1]), slice(*box[0])
    measured = arrays["measured"][part].astype(np.float64)
    if "exact" in arrays:
        reference, low, high, outside = (
            arrays[name][part] for name in ("exact", "low", "high", "outside")
        )
        unit = float(arrays["unit"])
    else:
        low = high = reference = arrays["reference"][part].astype(np.float64)
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


def _window(start: int, stop: int, centre: int, size: int) -> tuple[int, int]:
    low = max(start, min(centre - size // 2, stop - size))
    return low, min(stop, low + size)


def _columns(values: Values) -> list[bytes]:
    judged = np.moveaxis(values.judged, -1, 0)
    all_judged = bool(judged.all())

    def planes(array: NDArray[Any], wanted: type = np.float32) -> NDArray[Any]:
        with np.errstate(over="ignore"):
            found: NDArray[Any] = np.ascontiguousarray(np.moveaxis(array, -1, 0), wanted)
        return found if all_judged else np.where(judged, found, wanted(0))

    measured, nearest, low, high = (
        _ordered(planes(a)) for a in (values.measured, values.reference, values.low, values.high)
    )
    exact = planes(values.reference, np.float64)
    with np.errstate(invalid="ignore", over="ignore"):
        near = exact.astype(np.float32)
        left = (exact - near) / np.spacing(np.abs(near))
        left[~np.isfinite(left)] = 0.0
    unit = 1 if values.fine else _COARSE
    whole = np.rint(np.clip(left, -0.5, 0.5) * (_REST / unit)) * unit
    rest = whole.clip(-32768, 32767).astype(np.int16)
    steps = measured.copy()
    steps[:, :, 1:] -= measured[:, :, :-1]
    steps[:, 1:, 0] -= measured[:, :-1, 0]
    flags = judged.astype(np.uint8)
    flags += np.moveaxis(values.outside, -1, 0).astype(np.uint8) << 1
    return [
        flags.tobytes(),
        _fold(steps),
        _fold(nearest - measured),
        _split(rest),
        _fold(low - nearest),
        _fold(nearest - high - (low - nearest)),
    ]


def _ordered(values: NDArray[np.float32]) -> NDArray[np.int32]:
    bits = np.ascontiguousarray(values).view(np.int32)
    return np.where(bits < 0, bits ^ np.int32(0x7FFFFFFF), bits)


def _fold(numbers: NDArray[np.int32]) -> bytes:
    return _split((numbers << 1) ^ (numbers >> 31))


def _split(numbers: NDArray[Any]) -> bytes:
    little = np.ascontiguousarray(numbers).astype(numbers.dtype.newbyteorder("<"))
    return little.view(np.uint8).reshape(-1, numbers.dtype.itemsize).T.tobytes()
