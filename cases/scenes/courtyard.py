"""A courtyard of boxes to throw shadows: all of it is boxes, so rays through it are exact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.assets.meshes import Geometry, cube, joined, moved

from .painted_solids import painted
from .remembered import remembered

Array = npt.NDArray[Any]

_Vector = tuple[float, float, float]
_Box = tuple[_Vector, _Vector, float, _Vector]

# Middle, size, turn about y in degrees, colour.
_BOXES: tuple[_Box, ...] = (
    ((0.0, -0.1, 0.0), (140.0, 0.2, 140.0), 0.0, (0.62, 0.54, 0.42)),
    ((-0.9, 0.45, 0.4), (0.5, 0.9, 0.5), 20.0, (0.80, 0.34, 0.16)),
    ((0.7, 0.3, 0.9), (0.6, 0.6, 0.6), 55.0, (0.18, 0.46, 0.56)),
    ((0.5, 0.7, -0.8), (0.35, 1.4, 0.35), 10.0, (0.80, 0.60, 0.18)),
    ((-0.1, 0.12, 1.7), (1.3, 0.24, 0.3), -12.0, (0.52, 0.20, 0.28)),
    ((-1.5, 0.2, -1.2), (0.4, 0.4, 0.9), 35.0, (0.36, 0.46, 0.24)),
    ((0.2, 1.35, 0.5), (0.5, 0.14, 0.5), 30.0, (0.74, 0.70, 0.64)),
)
_POSTS = ((0.80, 0.34, 0.16), (0.18, 0.46, 0.56), (0.80, 0.60, 0.18), (0.36, 0.46, 0.24))
_AVENUE: tuple[_Box, ...] = (
    _BOXES[0],
    *(
        ((side * 1.8, 0.8, -0.6 - 3.4 * k), (0.34, 1.6, 0.34), 17.0 * k, _POSTS[k % 4])
        for k in range(18)
        for side in (-1.0, 1.0)
    ),
)


def boxes() -> list[Array]:
    """The boxes' matrices, 4 × 4 each: they take the unit box around the origin to its place. The
    first is the floor, whose upper side is at y = 0.

    >>> len(boxes())
    7
    """
    return [_matrix(middle, size, turn) for middle, size, turn, _ in _BOXES]


@remembered
def courtyard() -> Geometry:
    """All boxes as one mesh; vertices have a colour, `aColor`.

    >>> sorted(courtyard()["attributes"])
    ['aColor', 'aNormal', 'aPos']
    """
    return _built(_BOXES)


def avenue_boxes() -> list[Array]:
    """The boxes of `avenue`, as those of `boxes`.

    >>> len(avenue_boxes())
    37
    """
    return [_matrix(middle, size, turn) for middle, size, turn, _ in _AVENUE]


@remembered
def avenue() -> Geometry:
    """A long straight road between posts, from z = 0 to z = −60: something with a near and a far.

    >>> sorted(avenue()["attributes"])
    ['aColor', 'aNormal', 'aPos']
    """
    return _built(_AVENUE)


def before(geometry: Geometry, model: Array) -> Geometry:
    """The geometry as a mesh has to hold it, for a rotation and translation to put it in place.

    >>> before(avenue(), np.diag([-1.0, 1.0, -1.0, 1.0]))["attributes"]["aPos"].max().item() > 0
    True
    """
    back, world = np.linalg.inv(model), geometry["attributes"]
    local = {
        **world,
        "aPos": world["aPos"] @ back[:3, :3].T + back[:3, 3],
        "aNormal": world["aNormal"] @ back[:3, :3].T,
    }
    return {**geometry, "attributes": local}


def _built(boxes: Sequence[_Box]) -> Geometry:
    return joined(
        *(
            painted(moved(cube(), _matrix(middle, size, turn)), color)
            for middle, size, turn, color in boxes
        )
    )


def _matrix(middle: _Vector, size: _Vector, turn: float) -> Array:
    angle = np.radians(turn)
    matrix = np.eye(4)
    matrix[0, [0, 2]] = np.cos(angle), np.sin(angle)
    matrix[2, [0, 2]] = -np.sin(angle), np.cos(angle)
    matrix[:3, :3] *= np.asarray(size, float)
    matrix[:3, 3] = middle
    return matrix
