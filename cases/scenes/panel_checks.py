"""Checks of pictures made of panels: a picture and the judged one show the same, enlarged or at
half the size, and nothing is left empty."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from shaderlab import measure, reading


def enlarged_check(
    judged: str = "small", large: str = "picture", *, edges: float | None = None
) -> Any:
    """What a small pass shows, the picture shows: its pixels that have the same centres are alike.

    Both are to differ by less than half a code of eight bits, which no eye sees: places are
    interpolated in floats, and what is steep in them differs in more than a last bit. Nor may the
    picture have a hole where the small pass has none.

    Args:
        judged: the small pass.
        large: the one that is an odd number of times as large.
        edges: given where meshes have edges. Corners are moved to a grid within the pixels
            (OpenGL 3.3, 3.6.1), which is finer in the large picture, so an edge may lie one small
            pixel further: a pixel of each must be like one of the other's neighbours then, but for
            this share, `at_edges`, as an edge that is shaded may have a colour of its own.

    >>> enlarged_check().name
    'the picture is the judged one, enlarged'
    """
    return measure(
        "the picture is the judged one, enlarged",
        share_unlike if edges is None else share_unlike_but_edges,
        reads={"large": f"{large}.FragColor", "small": f"{judged}.FragColor"},
        at_most=edges or 0.0,
        note="the share of pixels that are half a code of eight bits apart, or more",
    )


def share_unlike(large: npt.NDArray[Any], small: npt.NDArray[Any]) -> float:
    """The share of small pixels that the middles of blocks of large ones are not like, or that
    stand for a block with a hole.

    >>> small = np.zeros((1, 2, 1))
    >>> large = np.repeat(np.repeat(small, 3, axis=0), 3, axis=1)
    >>> large[1, 4] = 0.5
    >>> share_unlike(large, small)
    0.5
    """
    apart = np.abs(middles(large, small) - small).max(axis=-1)
    return float(np.mean(~(apart < 0.5 / 255.0) | holes(large, small)))  # NaN is like nothing


def share_unlike_but_edges(
    large: npt.NDArray[Any], small: npt.NDArray[Any], subpixel_step: float = 2.0**-8
) -> float:
    """As `share_unlike`, where a neighbour's colour will do: what one has and the other lacks
    counts, and what lies a pixel further does not.

    >>> small = np.zeros((1, 6, 1))
    >>> small[0, 1] = 1.0
    >>> large = np.repeat(np.repeat(np.roll(small, 1, axis=1), 3, axis=0), 3, axis=1)
    >>> share_unlike_but_edges(large, small), share_unlike_but_edges(0.0 * large, small) > 0.1
    (0.0, True)
    """
    middle = middles(large, small)
    apart = np.maximum(to_neighbours(middle, small), to_neighbours(small, middle))
    unlike = ~(apart < 0.5 / 255.0) | holes(large, small)
    return at_edges(float(np.mean(unlike)), subpixel_step)


def holes(large: npt.NDArray[Any], small: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Small pixels that are drawn on, as all about them are, and stand for a block of large ones of
    which one is not: all its channels are 0.

    >>> small = np.ones((1, 2, 4))
    >>> large = np.repeat(np.repeat(small, 3, axis=0), 3, axis=1)
    >>> large[:, 5] = 0.0
    >>> holes(large, small).tolist()
    [[False, True]]
    """
    (height, width), by = small.shape[:2], len(large) // len(small)
    filled = _drawn_on(large).reshape(height, by, width, by).all(axis=(1, 3))
    empty = np.asarray(~filled)
    if empty.any():
        around = np.pad(_drawn_on(small), 1, constant_values=True)
        empty &= sliding_window_view(around, (3, 3)).all(axis=(2, 3))
    return empty


def _drawn_on(picture: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Pixels that have a channel which is not 0."""
    channels = [picture[..., k] != 0.0 for k in range(picture.shape[-1])]
    return np.asarray(functools.reduce(np.logical_or, channels))


def filled_check(of: str) -> Any:
    """Something opaque is drawn on each pixel of a pass that is cleared to nothing: a sky, say.

    >>> filled_check("scene").name
    'scene: no pixel is left empty'
    """
    return measure(
        f"{of}: no pixel is left empty",
        share_empty,
        reads={"shown": f"{of}.FragColor"},
        equals=0.0,
        digits=9,
        own_types=True,
        note="the share of pixels whose alpha is 0",
    )


def share_empty(shown: npt.NDArray[Any]) -> float:
    """The share of pixels whose alpha is 0.

    >>> share_empty(np.array([[[1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 0.0]]]))
    0.5
    """
    return float(np.mean(shown[..., 3] == 0.0))


def smaller_check(judged: str = "judged", large: str = "scene", *, edges: float = 0.0) -> Any:
    """What a small pass shows of a scene of solids, the large one shows at the same place.

    Args:
        judged: the small pass.
        large: the same draws in a target at least three times as large, any number of times.
        edges: the share of pixels that may differ, where what is seen is thinner than they are,
            `at_edges`.

    >>> smaller_check().name
    'the large scene shows what the judged one does'
    """
    return measure(
        "the large scene shows what the judged one does",
        share_unseen,
        reads={"large": f"{large}.FragColor", "small": f"{judged}.FragColor"},
        at_most=edges,
        own_types=True,
        note="the share of pixels whose colour lies out of the range about the same place",
    )


def at_edges(share: float, subpixel_step: float) -> float:
    """A share of pixels at edges, as it would be on a grid of 1/256 pixel.

    Corners are moved to a driver's grid (OpenGL 3.3, 3.6.1), and edges with them by up to a step:
    faces that are thinner vanish, and what they hide is seen. As many pixels have their centre in
    such a strip as it is wide.

    >>> at_edges(0.008, 1 / 16)
    0.0005
    """
    return share / (256.0 * subpixel_step)


def share_unseen(
    large: npt.NDArray[Any], small: npt.NDArray[Any], subpixel_step: float = 2.0**-8
) -> float:
    """The share of small pixels `at_edges` that are, by half a code of eight bits or more in any
    channel, out of the range of what is large at their places and half a small pixel around.

    >>> small = np.zeros((1, 4, 1))
    >>> large = np.zeros((3, 12, 1))
    >>> small[0, 1], large[:, 3:6] = 1.0, 1.0
    >>> share_unseen(large, small), share_unseen(np.zeros((3, 12, 1)), small)
    (0.0, 0.25)
    """
    low, high = (_around(large, small.shape, extreme) for extreme in (np.min, np.max))
    apart = np.maximum(low - small, small - high).max(axis=-1)
    return at_edges(float(np.mean(apart >= 0.5 / 255.0)), subpixel_step)


def _around(large: npt.NDArray[Any], shape: tuple[int, ...], extreme: Any) -> npt.NDArray[Any]:
    """The least or the greatest of a large picture within a pixel's reach of each small one."""
    for count in shape[:2]:  # by rows, then, the axes exchanged, by columns
        by, places = len(large) / count, np.arange(count)
        starts = np.floor(np.maximum(places - 0.5, 0.0) * by).astype(int)
        stops = np.ceil(np.minimum(places + 1.5, count) * by).astype(int)
        parts = [extreme(large[a:b], axis=0) for a, b in zip(starts, stops, strict=True)]
        large = np.stack(parts, axis=1)
    return large.astype(np.float64)


def middles(large: npt.NDArray[Any], small: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The pixels of a large picture that have the centres of a small one's."""
    by = len(large) // len(small)
    return large[by // 2 :: by, by // 2 :: by]


def to_neighbours(of: npt.NDArray[Any], among: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """How far each pixel is from that of another image at its place, or of the eight about it,
    that is most like it."""
    height, width = of.shape[:2]
    around = np.pad(among, ((1, 1), (1, 1), (0, 0)), mode="edge")
    places = [(y, x) for y in range(3) for x in range(3)]
    apart = [np.abs(of - around[y : y + height, x : x + width]).max(axis=-1) for y, x in places]
    nearest: npt.NDArray[Any] = np.min(apart, axis=0)
    return nearest


def softened_check(of: str = "scene", name: str = "picture") -> Any:
    """Each channel of `softened_pass` is the mean light of four texels of the pass `of`, encoded.

    The bound: of numbers between 2⁻⁸ and 1, log2 errs by 3 ULP at most, 3·2⁻²¹, and exp2 of 2.2
    times it, above −18, by (3 + 36) ULP of the result: together less than 2⁻¹⁶ of the light. The
    numbers that stand for it err by 1/2.2 of that, and by as much again where they are encoded.

    >>> softened_check().name
    'four texels a pixel'
    """
    return measure(
        "four texels a pixel",
        furthest_from_mean,
        reads={"scene": f"{of}.FragColor", "picture": f"{name}.FragColor"},
        at_most=2.0**-16,
        own_types=True,
        note="the farthest that a channel is from the mean light of its four texels, encoded",
    )


def parts_check(
    outputs: Mapping[str, Any], *, at_most: float, of: str = "picture.FragColor"
) -> Any:
    """Each part of a picture shows the output that it should: a formula would take whatever is
    bound to the part's sampler.

    Args:
        outputs: what is shown → where: left, lower, right and upper edge, as shares of the picture.
        at_most: how far the mean colours of a sixteenth of both may be apart.
        of: the picture.

    >>> parts_check({"all.FragColor": (0.0, 0.0, 0.5, 1.0)}, at_most=0.01).name
    'each part of the picture shows its output'
    """
    return measure(
        "each part of the picture shows its output",
        furthest_sixteenth,
        reads={"picture": of},
        readings=[
            reading(output, reads={"part": output}, given={"place": place}, at_most=at_most)
            for output, place in outputs.items()
        ],
        own_types=True,
    )


def furthest_sixteenth(
    picture: npt.NDArray[Any], part: npt.NDArray[Any], place: npt.NDArray[Any]
) -> float:
    """How far the mean colour of a sixteenth of a part of the picture is from that of an image.

    >>> black, white = np.zeros((4, 4, 3)), np.ones((4, 4, 1))
    >>> furthest_sixteenth(np.hstack([black, black + 1.0]), white, np.array([0.5, 0.0, 1.0, 1.0]))
    0.0
    """
    height, width = picture.shape[:2]
    left, lower, right, upper = np.ravel(place)
    rows = slice(round(float(lower * height)), round(float(upper * height)))
    shown = picture[rows, round(float(left * width)) : round(float(right * width))]
    return float(np.abs(_sixteenths(shown) - _sixteenths(part)).max())


def _sixteenths(image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    blocks = (b for row in np.array_split(image[..., :3], 4) for b in np.array_split(row, 4, 1))
    full = 255.0 if image.dtype == np.uint8 else 1.0
    return np.array([block.mean(axis=(0, 1), dtype=float) / full for block in blocks])


ROWS_AT_ONCE = 16
GAMMA = np.float32(2.2)
"""Single precision, which takes a third of the time, errs by less than a sixteenth of the bound."""


def furthest_from_mean(scene: npt.NDArray[Any], picture: npt.NDArray[Any]) -> float:
    """How far a picture of half the size is, at most, from the mean light of four texels, encoded
    with a gamma of 2.2; and its fourth channel from 1.

    >>> scene = np.array([[[1.0], [0.0]], [[1.0], [0.0]]])
    >>> round(furthest_from_mean(scene, np.array([[[0.75]]])), 5)
    0.02026
    """
    furthest = 0.0
    # Some rows at a time stay in the processor's cache, and a channel lies side by side.
    for row in range(0, len(picture), ROWS_AT_ONCE):
        part = _channels(picture[row : row + ROWS_AT_ONCE])
        light = _channels(scene[2 * row : 2 * (row + ROWS_AT_ONCE), :, :3]) ** GAMMA
        rows = light[:, 0::2] + light[:, 1::2]
        mean = np.float32(0.25) * (rows[..., 0::2] + rows[..., 1::2])
        furthest = np.maximum(furthest, np.abs(mean ** (1 / GAMMA) - part[:3]).max())
        furthest = np.maximum(furthest, np.abs(part[3:] - 1.0).max(initial=0.0))
    return float(furthest)


def _channels(rows: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    return np.moveaxis(rows, -1, 0).astype(np.float32, order="C")
