"""The colours of numbers: the map "viridis" (Stéfan van der Walt and Nathaniel Smith, CC0), as
OpenImageIO draws it, and those of places in a band, as red, green and blue from 0 to 255.
"""

import math
from functools import cache, reduce
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shaderlab.errors import AssetError

Colour = tuple[int, int, int]

NOT_FINITE: Colour = (255, 0, 255)
BAND_LOW: Colour = (33, 102, 172)
BAND_MIDDLE: Colour = (247, 247, 247)
BAND_HIGH: Colour = (224, 130, 20)
# Of a value outside, in a check with black: as far as so many half band widths, and beyond.
MAGNITUDES = (10.0, 100.0, 1e4, 1e6)
OUTSIDE: tuple[Colour, ...] = (
    (138, 10, 20),
    (208, 24, 20),
    (250, 96, 36),
    (255, 176, 56),
    (255, 246, 150),
)
CHECK: Colour = (0, 0, 0)
UNCOVERED: Colour = (205, 205, 205)
# 256 colours from dark to bright, two hexadecimal digits each of red, green and blue.
VIRIDIS = "".join(Path(__file__).with_name("viridis.txt").read_text(encoding="ascii").split())


Bytes = NDArray[np.uint8]

_SHADES = 8
_RAMP: Bytes = np.frombuffer(bytes.fromhex(VIRIDIS), np.uint8).reshape(-1, 3)


class Display(NamedTuple):
    """A picture and how to read it.

    `image` is uint8 (height, width, 3 or 4); `low` and `high` are the values that its darkest
    and brightest colours stand for; `caption` says so in words, with what was clipped or marked.
    """

    image: Bytes
    low: float
    high: float
    caption: str


def to_display(array: NDArray[Any], *, value_range: tuple[float, float] | None = None) -> Display:
    """An array as a plain OpenGL window would show it, or in false colour.

    Three and four channels of floats are clipped to 0…1 without any gamma, and 8-bit values
    are kept. Two channels are red and green. One channel of any type is false-coloured over
    its finite range, wider integers of several channels become levels over theirs. A pixel
    that holds a NaN or an infinity is magenta. A window ignores a fourth channel, so it is dropped.

    Args:
        array: (height, width) or (height, width, 1…4) of floats, integers or booleans.
        value_range: the values of the first and the last colour, where two pictures are to be
            compared; the array's own range by default. Direct colours ignore it.

    Raises AssetError: the array has no such shape or type."""
    pixels = as_pixels(array)
    channels = pixels.shape[2]
    if channels == 1:
        return _false_colour(pixels[:, :, 0], value_range)
    if pixels.dtype == np.uint8:
        return Display(_as_rgb(pixels), 0.0, 255.0, "8-bit values as they are")
    if pixels.dtype.kind in "iu":
        low, high = value_range or _finite_range(pixels)
        scaled = (pixels.astype(np.float64) - low) / ((high - low) or 1.0)
        levels = np.rint(np.clip(scaled, 0, 1) * 255).astype(np.uint8)
        caption = f"integers as levels from {low:.9g} to {high:.9g}"
        return Display(_as_rgb(levels), low, high, caption)
    return _clip(pixels)


def distance_picture(widths: NDArray[Any], outside: NDArray[Any]) -> tuple[Bytes, Bytes]:
    """Where in its band each value lies, as indices into a palette of few colours.

    Blue is the band's lower end, white its middle, orange its upper end. A value outside is a
    check of black and of a colour of `OUTSIDE`, brighter the further it is; an uncovered pixel is
    light grey.

    Args:
        widths: signed distance from the band's middle in half band widths, −1…1 inside, NaN
            where nothing was drawn: (height, width) or (height, width, components), of which
            the largest distance is shown.
        outside: booleans of the same shape; a value that is outside counts even where its
            distance is NaN.

    Returns uint8, row 0 at the bottom, and the palette, uint8 (colours, 3). Where a value is
    outside, each is a square of 2 × 2, or the check could not be seen."""
    distance = np.asarray(widths, dtype=np.float64)
    beyond = np.asarray(outside, dtype=bool)
    if distance.shape != beyond.shape or distance.ndim not in (2, 3) or not distance.size:
        raise AssetError(
            f"distances {distance.shape} and outside {beyond.shape} must have one shape, "
            "(height, width) or (height, width, components)"
        )
    if distance.ndim == 3:
        nowhere = np.where(beyond, np.inf, -1.0)
        beyond = np.asarray(beyond.any(axis=2))
        size = np.where(np.isnan(distance), nowhere, np.abs(distance))
        furthest = size.argmax(axis=2)[:, :, None]
        distance = np.take_along_axis(distance, furthest, axis=2)[:, :, 0]

    table = _distance_palette()
    uncovered, dark = 2 * _SHADES + 1, len(table) - 1
    # Eight shades to each side are told apart, and make a file of half the size.
    with np.errstate(invalid="ignore"):
        steps = np.rint(np.clip(distance, -1.0, 1.0) * _SHADES) + _SHADES
    picture = np.where(np.isnan(steps), uncovered, steps).astype(np.uint8)

    if not beyond.any():
        return picture, table
    light = uncovered + 1 + np.searchsorted(MAGNITUDES, np.abs(distance))  # a NaN is beyond all
    large = enlarge(picture, 2)
    y, x = np.indices(large.shape)
    check = np.where((x + y) % 2, dark, enlarge(light, 2))
    return np.where(enlarge(beyond, 2), check, large).astype(np.uint8), table


def _distance_palette() -> Bytes:
    """The colours from a band's lower end to its upper one, of an uncovered pixel, of checks."""
    t = np.arange(-_SHADES, _SHADES + 1)[:, None] / _SHADES
    middle = np.array(BAND_MIDDLE, dtype=np.float64)
    end = np.where(t < 0, np.array(BAND_LOW, dtype=np.float64), np.array(BAND_HIGH))
    shades = np.rint(middle + (end - middle) * np.abs(t))
    return np.array([*shades, UNCOVERED, *OUTSIDE, CHECK], dtype=np.uint8)


def as_pixels(array: NDArray[Any]) -> NDArray[Any]:
    """The array as (height, width, 1…4), booleans as 0 and 1; AssetError for anything else."""
    pixels = np.asarray(array)
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    if pixels.ndim != 3 or not 1 <= pixels.shape[2] <= 4 or not pixels.size:
        raise AssetError(f"a picture is (height, width, 1…4 channels), not {np.shape(array)}")
    if pixels.dtype.kind == "b":
        return pixels.astype(np.uint8)
    if pixels.dtype.kind not in "iuf":
        raise AssetError(f"a picture is made of numbers, not of {pixels.dtype}")
    return pixels


def _as_rgb(levels: Bytes) -> Bytes:
    if levels.shape[2] == 3:
        return np.ascontiguousarray(levels)
    image = np.zeros((*levels.shape[:2], 3), dtype=np.uint8)
    _copy_channels(levels, image)
    return image


def _copy_channels(pixels: NDArray[Any], into: NDArray[Any]) -> None:
    """Copy as many channels as both have: one after the other takes a third of the time."""
    for channel in range(min(pixels.shape[2], into.shape[2])):
        into[:, :, channel] = pixels[:, :, channel]


def _clip(pixels: NDArray[Any]) -> Display:
    wanted = np.float32 if pixels.dtype == np.float16 else pixels.dtype  # processors add no halves
    shown = np.empty((*pixels.shape[:2], min(pixels.shape[2], 3)), wanted)
    _copy_channels(pixels, shown)
    low, high = _range(shown)
    broken = None
    if not (math.isfinite(low) and math.isfinite(high)):
        low, high = _finite_range(shown)
        finite = np.isfinite(shown)
        broken = ~finite.all(axis=2)
        shown[~finite] = 0
    if low < 0 or high > 1:
        np.clip(shown, 0, 1, out=shown)
    shown *= 255
    image = _as_rgb(np.rint(shown, out=shown).astype(np.uint8))
    words = "red and green, 0 to 1" if shown.shape[2] == 2 else "colours as drawn, 0 to 1"
    if low < 0 or high > 1:
        words += f"; clipped, values run from {low:.6g} to {high:.6g}"
    if broken is not None:
        image[broken] = NOT_FINITE
        words += _magenta(int(np.count_nonzero(broken)))
    return Display(image, 0.0, 1.0, words)


def _false_colour(values: NDArray[Any], value_range: tuple[float, float] | None) -> Display:
    finite = np.isfinite(values)
    low, high = value_range or _finite_range(values)
    # Halved, so that the range of the largest floats does not overflow.
    span = (high / 2 - low / 2) or 1.0
    scaled = np.clip((np.where(finite, values, low) / 2 - low / 2) / span, 0, 1)
    levels = np.rint(scaled * (len(_RAMP) - 1)).astype(np.uint8)
    image = np.take(_RAMP, levels, axis=0)  # indexing takes four times as long
    image[~finite] = NOT_FINITE
    words = f"one channel in false colour, {low:.6g} (dark) to {high:.6g} (bright)"
    return Display(image, float(low), float(high), words + _magenta(int((~finite).sum())))


def _range(values: NDArray[Any]) -> tuple[float, float]:
    with np.errstate(invalid="ignore"):
        return float(values.min()), float(values.max())


def _finite_range(values: NDArray[Any]) -> tuple[float, float]:
    low, high = _range(values)
    if math.isfinite(low) and math.isfinite(high):  # then there is no other
        return low, high
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)


def _magenta(count: int) -> str:
    return f"; magenta: {count} not finite" if count else ""


def enlarge(pixels: NDArray[Any], factor: int) -> NDArray[Any]:
    """Each pixel as a square of `factor` × `factor`."""
    return pixels if factor == 1 else pixels.repeat(factor, axis=1).repeat(factor, axis=0)


def shrink(pixels: Bytes, factor: int) -> Bytes:
    """The mean light of each `factor` × `factor` pixels; what is left over at the edges is cut."""
    height, width = (side // factor for side in pixels.shape[:2])
    light, codes = _light_tables(factor**2)
    small = np.empty((height, width, pixels.shape[2]), np.uint8)
    for y in range(0, height, 16):  # so few rows stay in a processor's cache
        until = min(y + 16, height)
        lit = light.take(pixels[y * factor : until * factor, : width * factor], mode="clip")
        rows = reduce(np.add, [lit[k::factor] for k in range(factor)])
        for c in range(pixels.shape[2]):  # all at once takes longer
            sums = reduce(np.add, [rows[:, k::factor, c] for k in range(factor)])
            small[y:until, :, c] = codes.take(sums, mode="clip")  # quicker than "raise"
    return small


@cache
def _light_tables(parts: int) -> tuple[NDArray[np.uint16], Bytes]:
    """The light of each 8-bit code, so that `parts` of the brightest make 65535, and the code of
    each light. Source: IEC 61966-2-1 (sRGB)."""
    code, light = np.arange(256) / 255, np.arange(65536) / 65535
    decoded = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.rint(65535 // parts * decoded).astype(np.uint16), np.rint(255 * encoded).astype("u1")
