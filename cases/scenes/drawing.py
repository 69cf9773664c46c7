"""What the strokes of lib/drawing.glsl give: lines of a width in pixels, fields, encoded light."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import reduce

import numpy as np

from shaderlab.glslmath import (
    Value,
    abs,
    either,
    floor,
    fract,
    max,
    min,
    mix,
    pow,
    smoothstep,
    swizzle,
    vec2,
    vec3,
)

AMBER, BLUE = (1.00, 0.72, 0.25), (0.45, 0.70, 1.00)
"""The colours of lines in pictures."""

REACH = (0, -1, 1)
"""How far pixels lie from one, in pixels, between which GLSL may measure a change."""

Field = Callable[[Value], Value]
Color = tuple[float, float, float]


def encoded(light: Value) -> Value:
    """Light as the numbers a display expects, cut at 1, with a gamma of 2.2.

    >>> encoded(np.array([0.0, 0.5, 2.0])).round(6).tolist()
    [0.0, 0.72974, 1.0]
    """
    return pow(min(light, 1.0), 1.0 / 2.2)


def decoded(shown: Value) -> Value:
    """The light that a display makes of its numbers, with a gamma of 2.2.

    >>> decoded(np.array([0.72974, 1.0])).round(6).tolist()
    [0.5, 1.0]
    """
    return pow(shown, 2.2)


def chessboard(place: Value) -> Value:
    """0 and 1 on the fields of a chessboard of unit squares: whether the field's number is odd.

    >>> chessboard(np.array([[0.5, 0.5], [1.5, 0.5], [-0.5, 0.5]])).ravel().tolist()
    [0.0, 1.0, 1.0]
    """
    number = floor(swizzle(place, "x")) + floor(swizzle(place, "y"))
    return 2.0 * fract(0.5 * number)


def bayer_threshold(frag_coord: Value) -> Value:
    """Bayer's 8 × 8 matrix of thresholds over dots of 2 × 2 pixels: D₂ₙ = (4 Dₙ, 4 Dₙ + 2;
    4 Dₙ + 3, 4 Dₙ + 1), from D₁ = 0 (B. E. Bayer, 1973); 1/128 … 127/128.

    >>> bayer_threshold(np.array([[0.5, 0.5], [2.5, 2.5]])).ravel().tolist()
    [0.0078125, 0.2578125]
    """
    dot = floor(0.5 * swizzle(frag_coord, "xy"))
    level: Value = 1.0 / 128.0
    for bit in range(3):
        odd = 2.0 * fract(0.5 * floor(dot * 0.5**bit))
        x, y = swizzle(odd, "x"), swizzle(odd, "y")
        level = level + (2.0 * abs(x - y) + y) * 0.25 ** (bit + 1)
    return level


def pixel_size(place: Value, corner: Value | Sequence[float], frag_coord: Value) -> Value:
    """How far apart neighbouring pixels are, (…, 2): of two coordinates that grow evenly over the
    target, to the right and upward, from the values that they have in its lower left corner.

    >>> pixel_size(np.array([0.25, 3.0]), (0.0, 2.0), np.array([0.5, 2.5, 0.0, 1.0])).tolist()
    [0.5, 0.4]
    """
    origin = np.asarray(corner) if isinstance(corner, Sequence) else corner
    return (place - origin) / swizzle(frag_coord, "xy")


def change(field: Field, place: Value, size: Value) -> Value:
    """How much a field changes from pixel to pixel, to the right and upward together: fwidth.

    GLSL may take the next pixel on either side, in this row or column or in one beside it (4.60,
    8.14.1). A band allows them all.

    Args:
        field: a function of the place.
        place: two coordinates that grow evenly over the target, to the right and upward.
        size: how far apart neighbouring pixels are, from `pixel_size`.

    >>> change(lambda place: place[..., :1] * 3.0, np.zeros((1, 2)), np.array([0.5, 0.1])).item()
    1.5
    """
    return _change_of({k: field(near) for k, near in _places_around(place, size).items()})


def _places_around(place: Value, size: Value) -> dict[tuple[int, int], Value]:
    """The pixel's place, and those of its neighbours, by how far they are off."""
    right, up = vec2(swizzle(size, "x"), 0.0), vec2(0.0, swizzle(size, "y"))
    return {(x, y): place + (x * right + y * up) for x in REACH for y in REACH}


def _change_of(near: Mapping[tuple[int, int], Value]) -> Value:
    across = [near[k + 1, aside] - near[k, aside] for aside in REACH for k in (0, -1)]
    upward = [near[aside, k + 1] - near[aside, k] for aside in REACH for k in (0, -1)]
    return reduce(either, map(abs, across)) + reduce(either, map(abs, upward))


def line(field: Field, place: Value, size: Value, width: float) -> Value:
    """1 on the curve where a field is 0, `width` pixels wide, with soft edges.

    Args:
        field, place, size: as `change` takes them.
        width: in pixels.

    >>> size, across = np.array([0.1, 0.1]), lambda place: place[..., :1] - 1.0
    >>> line(across, np.array([[1.0, 0.0], [1.1, 0.0], [1.3, 0.0]]), size, 2.0).ravel().tolist()
    [1.0, 0.5, 0.0]
    """
    return _line_of(field(place), change(field, place, size), width)


def _line_of(value: Value, change: Value, width: float) -> Value:
    pixels = abs(value) / max(change, 1.0e-12)
    return 1.0 - smoothstep(0.5 * width - 0.5, 0.5 * width + 0.5, pixels)


def with_lines(
    color: Value,
    place: Value,
    size: Value,
    rows: Iterable[tuple[Field, float, Color, Value]],
    *,
    of: Field = lambda place: place,
) -> Value:
    """A colour with lines over it, one after the other.

    Args:
        color: what is below them, (…, 3).
        place, size: as `change` takes them.
        rows: of each line its field, its width in pixels, its colour and how much it covers.
        of: what the fields are functions of, in place of the place: evaluated once for them all.

    >>> rows = [(lambda place: place[..., :1], 2.0, (1.0, 0.5, 0.0), 0.5)]
    >>> with_lines(np.zeros(3), np.zeros((1, 2)), np.array([0.1, 0.1]), rows).tolist()
    [[0.5, 0.25, 0.0]]
    """
    here, around = of(place), {k: of(near) for k, near in _places_around(place, size).items()}
    for field, width, hue, strength in rows:
        change = _change_of({k: field(near) for k, near in around.items()})
        color = mix(color, vec3(*hue), strength * _line_of(field(here), change, width))
    return color
