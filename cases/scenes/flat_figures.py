"""Flat figures of coloured triangles: a fish, a butterfly, numbers in memory as squares; and their
pictures with smooth edges."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from shaderlab import Draw, Mesh, Pass, measure

from .panel_checks import smaller_check, softened_check
from .panels import picture, softened_pass

Corners = Sequence[tuple[float, float]]
Hue = tuple[float, float, float]
ORANGE, WHITE, BLACK = (1.0, 0.22, 0.02), (0.95, 0.95, 0.9), (0.005, 0.005, 0.008)
# A fish that swims to the left: corners of its parts, 64 from the middle to the edge, and the
# colours of their corners. Each part is convex and begins with the corner that its fan turns about.
_FIN, _PALE = (0.55, 0.08, 0.01), (1.0, 0.5, 0.1)
_FISH: Sequence[tuple[Corners, Sequence[Hue]]] = (
    (((34, 0), (61, 31), (52, 0), (61, -31)), (ORANGE, _FIN, ORANGE, _FIN)),
    (((-14, 28), (26, 18), (12, 51), (-4, 50)), (ORANGE, ORANGE, _FIN, _FIN)),
    (((-8, -26), (2, -49), (17, -45), (20, -22)), (ORANGE, _FIN, _FIN, ORANGE)),
    (((-61, 1), (-55, -11), (-43, -22), (-43, 24), (-55, 13)),
     (_PALE, _PALE, ORANGE, ORANGE, _PALE)),
    (((-43, -22), (-28, -29), (-28, 31), (-43, 24)), (ORANGE,) * 4),
    (((-28, -29), (-15, -31), (-15, 33), (-28, 31)), (WHITE,) * 4),
    (((-15, -31), (6, -28), (6, 30), (-15, 33)), (ORANGE, _PALE, ORANGE, ORANGE)),
    (((6, -28), (18, -22), (18, 24), (6, 30)), (WHITE,) * 4),
    (((18, -22), (37, -7), (37, 9), (18, 24)), (_PALE, ORANGE, ORANGE, ORANGE)),
    (((-46, 4), (-38, 4), (-34, 8), (-34, 14), (-38, 18), (-46, 18), (-50, 14), (-50, 8)),
     (WHITE,) * 8),
    (((-46, 7), (-41, 7), (-39, 11), (-41, 15), (-46, 15), (-48, 11)), (BLACK,) * 6),
)  # fmt: skip
_DARK, _BLUE, _SKY, _SUN = (0.01, 0.01, 0.05), (0.02, 0.09, 0.6), (0.1, 0.55, 0.9), (1.0, 0.6, 0.05)
# The right half of a butterfly, whose left half is its mirror image.
_WINGS: Sequence[tuple[Corners, Sequence[Hue]]] = (
    (((2, 6), (31, 4), (53, 22), (61, 47), (49, 57), (25, 43)),
     (_SKY, _BLUE, _BLUE, _DARK, _DARK, _BLUE)),
    (((2, 2), (4, -28), (15, -52), (29, -55), (43, -37), (45, -14), (31, 2)),
     (_SKY, _BLUE, _DARK, _DARK, _DARK, _BLUE, _BLUE)),
    (((41, 31), (49, 29), (53, 38), (47, 45), (39, 41)), (_SUN,) * 5),
    (((21, -37), (29, -39), (35, -30), (31, -22), (23, -25)), (_SUN,) * 5),
)  # fmt: skip
_BODY: Sequence[tuple[Corners, Sequence[Hue]]] = (
    (((0, -38), (5, -18), (5, 22), (0, 30), (-5, 22), (-5, -18)), (_DARK,) * 6),
    (((2, 26), (18, 51), (15, 53)), (_DARK,) * 3),
    (((-2, 26), (-15, 53), (-18, 51)), (_DARK,) * 3),
)


def fish(**memory: Any) -> Mesh:
    """A clown fish in device coordinates; `memory` is `layout`, `usage` and `upload` of a Mesh.

    >>> len(fish(layout="interleaved").indices) // 3
    29
    """
    return _flat(_FISH, memory)


def butterfly(**memory: Any) -> Mesh:
    """A butterfly in device coordinates; `memory` as in `fish`.

    >>> float(abs(butterfly().attributes["aPos"][:, 0].sum()))
    0.0
    """
    mirrored = [([(-x, y) for x, y in part], hues) for part, hues in _WINGS]
    return _flat((*_WINGS, *mirrored, *_BODY), memory)


def memory_map(mesh: Mesh, columns: int = 6, top: int = 48) -> Mesh:
    """The floats of a mesh's vertex buffers as squares, in rows from the upper left, buffers one
    after the other: places in greys, colours in reds, greens and blues, the brighter the larger.
    They begin at a height of `top`, of 64.

    >>> corners = Mesh(attributes={"aPos": np.zeros((1, 3)), "aColor": np.ones((1, 3))})
    >>> memory_map(corners).attributes["aColor"][::4].round(1).tolist()
    [[0.5, 0.5, 0.5], [0.5, 0.5, 0.5], [0.5, 0.5, 0.5], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], \
[0.0, 0.0, 1.0]]
    """
    rows = []
    for name, array in mesh.attributes.items():
        placed = mesh.placements()[name]
        for vertex, numbers in enumerate(array):
            for k, number in enumerate(numbers):
                at = (placed.buffer, (placed.offset + vertex * placed.stride) // 4 + k)
                grey = (0.5 + 0.5 * number,) * 3
                hue = np.eye(3)[k] * (0.1 + 0.9 * number) if name == "aColor" else grey
                rows.append((at, hue))
    parts = []
    for n, (_, hue) in enumerate(sorted(rows, key=lambda row: row[0])):
        x, y = 14 * (n % columns) - 7 * columns + 1, top - 14 * (n // columns)
        square = ((x, y - 12), (x + 12, y - 12), (x + 12, y), (x, y))
        parts.append((square, [tuple(hue)] * 4))
    return _flat(parts, {})


def squares_check(columns: int) -> Any:
    """Squares that fill whole pixels of "small" are as sharp in "picture", which is enlarged: in so
    many columns of pixels, counted in the small one.

    >>> squares_check(128).name
    'no square is a pixel off'
    """
    return measure(
        "no square is a pixel off",
        _share_off,
        reads={"large": "picture.FragColor", "small": "small.FragColor"},
        given={"columns": columns},
        equals=0.0,
        digits=9,
        own_types=True,
    )


def pictured(draws: Iterable[Draw], size: tuple[int, int], clear: Any) -> tuple[Pass, ...]:
    """Passes "scene" and "picture", with smooth edges, for people, and a sixth as large "judged".

    Args:
        draws: the same for all of them.
        size: of the picture in pixels.
        clear: its background.

    >>> draws = [Draw(vertex="a.vert", fragment="a.frag", mesh=fish())]
    >>> [one.target.size for one in pictured(draws, (960, 480), (0, 0, 0, 1))]
    [(1920, 960), (960, 480), (160, 80)]
    """
    draws, (width, height) = tuple(draws), size
    only = {"colors": {"FragColor": "rgba32f"}}
    return (
        picture(draws, (2 * width, 2 * height), "scene", clear=clear, **only),
        *softened_pass("scene", size, domain={}),
        picture(draws, (width // 6, height // 6), "judged", clear=clear),
    )


def pictured_checks(edges: float = 0.0) -> list[Any]:
    """What must hold of `pictured`; `edges` as in `smaller_check`.

    >>> [check.name for check in pictured_checks()]
    ['four texels a pixel', 'the large scene shows what the judged one does']
    """
    return [softened_check(), smaller_check(edges=edges)]


def _share_off(large: Any, small: Any, columns: int) -> float:
    """The share of pixels that are not as the small one that they stand for."""
    by, columns = len(large) // len(small), int(columns)
    blocks = small[:, :columns].repeat(by, axis=0).repeat(by, axis=1)
    return float(np.mean(np.abs(large[:, : by * columns] - blocks) > 0.5 / 255.0))


def _flat(parts: Any, memory: dict[str, Any]) -> Mesh:
    """Parts over one another, each a fan."""
    places: list[Any] = []
    hues: list[Hue] = []
    fans: list[tuple[int, int, int]] = []
    for corners, colors in parts:
        first = len(places)
        fans += [(first, first + k, first + k + 1) for k in range(1, len(corners) - 1)]
        places += [(x / 64.0, y / 64.0, 0.0) for x, y in corners]
        hues += colors
    attributes = {"aPos": np.array(places), "aColor": np.array(hues)}
    return Mesh(attributes=attributes, indices=np.ravel(fans), **memory)
