"""What is really in shadow, by rays: the measure of every shadow map.

Source: A. Appel, "Some Techniques for Shading Machine Renderings of Solids", AFIPS 1968 (a ray
from the surface to the light decides); boxes as slabs as in `scenes.boxes`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shaderlab.reference.transforms import Matrix

from .boxes import slab_distance

_OFF = 1e-4


def blocked(
    places: ArrayLike, to_light: ArrayLike, models: Sequence[Matrix], reach: float = np.inf
) -> NDArray[np.bool_]:
    """Whether a box lies between each place and the light.

    Rays start 0.0001 of `to_light`'s length away from the surface, so that it does not block
    itself.

    Args:
        places: (…, 3), in the world.
        to_light: towards the light, (3,) or (…, 3); its length is the unit of `reach`.
        models: the boxes' matrices, from the unit box around the origin.
        reach: how far the light is, 1 where `to_light` ends in it; infinite for a sun.

    >>> from shaderlab.reference.transforms import translate
    >>> box = [translate((0.0, 2.0, 0.0))]
    >>> blocked([(0.2, 0.0, 0.0), (0.9, 0.0, 0.0)], (0.0, 1.0, 0.0), box).tolist()
    [True, False]
    """
    direction = np.broadcast_to(np.asarray(to_light, np.float64), np.shape(places))
    start = np.asarray(places, np.float64) + _OFF * direction
    found = np.zeros(start.shape[:-1], bool)
    for model in models:
        inverse = np.linalg.inv(np.asarray(model, np.float64))
        local = start @ inverse[:3, :3].T + inverse[:3, 3]
        distance = slab_distance(local, direction @ inverse[:3, :3].T)
        found |= distance < reach - _OFF
    return found


def hidden_share(
    eye: ArrayLike, models: Sequence[Matrix], step: int = 1
) -> Callable[[Matrix, Matrix], float]:
    """A statistic of a picture: the share of places in it that a box hides from the eye. A depth
    test that works leaves none, but for pixels at the very edges.

    Args:
        eye: the camera's place, (3,).
        models: the boxes' matrices.
        step: only each so manieth pixel both ways is looked at.

    Returns:
        a function of the picture, whose alpha is 0 where nothing is drawn, and of the places.

    >>> picture = np.ones((1, 2, 4))
    >>> places = np.array([[(0.0, 0.0, -2.0), (0.0, 2.0, -2.0)]])
    >>> hidden_share((0.0, 0.0, 2.0), [np.eye(4)])(picture, places)
    0.5
    """

    def share(FragColor: Matrix, place: Matrix) -> float:
        drawn, places = FragColor[::step, ::step, 3] > 0.0, place[::step, ::step, :3]
        to_eye = np.asarray(eye, np.float64) - places
        return float(blocked(places, to_eye, models, reach=1.0)[drawn].mean())

    return share


def wrongly_dark(shadow: ArrayLike, truth: ArrayLike, lit: ArrayLike) -> float:
    """The share of truly lit places that a shadow map darkens: shadow acne.

    Args:
        shadow: what the map says, 0…1; more than 0.5 is dark.
        truth: whether each place is blocked.
        lit: whether the surface faces the light there, and is there at all.

    >>> wrongly_dark([1.0, 0.0, 1.0, 0.0], [False, False, True, False], [True] * 4)
    0.3333333333333333
    """
    there = np.asarray(lit) & ~np.asarray(truth)
    return float(np.mean(np.asarray(shadow)[there] > 0.5))


def wrongly_bright(shadow: ArrayLike, truth: ArrayLike, lit: ArrayLike) -> float:
    """The share of truly shadowed places that a shadow map leaves lit: what too large a bias does.

    >>> wrongly_bright([1.0, 0.0, 1.0, 0.0], [True, True, True, False], [True] * 4)
    0.3333333333333333
    """
    there = np.asarray(lit) & np.asarray(truth)
    return float(np.mean(np.asarray(shadow)[there] <= 0.5))
