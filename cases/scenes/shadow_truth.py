"""What is really in shadow, by rays: the measure of every shadow map.

Source: A. Appel, "Some Techniques for Shading Machine Renderings of Solids", AFIPS 1968 (a ray
from the surface to the light decides); boxes as slabs as in `scenes.boxes`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shaderlab.reference.transforms import Matrix

from .boxes import slab_distance
from .panel_checks import at_edges

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
    direction = np.asarray(to_light, np.float64)
    start = np.asarray(places, np.float64) + _OFF * direction
    found = np.zeros(start.shape[:-1], bool)
    for model in models:
        inverse = np.linalg.inv(np.asarray(model, np.float64))
        local = start @ inverse[:3, :3].T + inverse[:3, 3]
        distance = slab_distance(local, direction @ inverse[:3, :3].T)
        found |= distance < reach - _OFF
    return found


def nearest_depths(
    places: ArrayLike,
    light_space: Matrix,
    size: int,
    models: Sequence[Matrix],
    shift: tuple[int, int] = (0, 0),
) -> Matrix:
    """What a shadow map made by rays holds for each place, with nothing rasterised: the depth, 0…1,
    of the box nearest to the light behind the middle of the place's texel; 1 where there is none.

    Args:
        places: (…, 3), in the world.
        light_space: the light's projection · view; parallel light.
        size: texels along each side of the map.
        models: the boxes' matrices.
        shift: by how many texels to look beside a place's own one.

    >>> from shaderlab.reference.transforms import scale
    >>> nearest_depths([(0.1, 0.2, -0.9), (0.9, 0.9, 0.0)], np.eye(4), 4, [np.eye(4)]).tolist()
    [0.25, 1.0]
    """
    device = np.asarray(places, np.float64) @ light_space[:3, :3].T + light_space[:3, 3]
    middles = (np.floor((0.5 * device[..., :2] + 0.5) * size) + shift + 0.5) / size
    near = np.ones((*middles.shape[:-1], 4))
    near[..., :2], near[..., 2] = 2.0 * middles - 1.0, -1.0
    far = near * (1.0, 1.0, -1.0, 1.0)
    depths = np.ones(middles.shape[:-1])
    for model in models:
        back = np.linalg.inv(light_space @ model).T
        start, end = ((p @ back)[..., :3] for p in (near, far))
        depths = np.minimum(depths, slab_distance(start, end - start))
    return depths


def nearest_distances(
    rays: ArrayLike, lamp: ArrayLike, size: int, models: Sequence[Matrix]
) -> Matrix:
    """The same of a cube map around a lamp: how far away the nearest box is in the direction of the
    middle of each ray's texel; infinite where there is none.

    Args:
        rays: from the lamp, (…, 3), of any length but 0.
        lamp: its place, (3,).
        size: texels along each side of a face.
        models: the boxes' matrices.

    >>> far = nearest_distances([(0.1, 0.2, -4.0), (0.0, 1.0, 0.1)], (0, 0, 1.5), 1, [np.eye(4)])
    >>> far.tolist()
    [1.0, inf]
    """
    directions = np.asarray(rays, np.float64)
    directions = directions / np.abs(directions).max(axis=-1, keepdims=True)
    middles = 2.0 * (np.floor((0.5 * directions + 0.5) * size) + 0.5) / size - 1.0
    directions = np.where(np.abs(directions) == 1.0, directions, middles)
    distances = np.full(directions.shape[:-1], np.inf)
    for model in models:
        back = np.linalg.inv(np.asarray(model, np.float64))
        start = np.asarray(lamp, np.float64) @ back[:3, :3].T + back[:3, 3]
        distances = np.minimum(distances, slab_distance(start, directions @ back[:3, :3].T))
    found: Matrix = distances * np.linalg.norm(directions, axis=-1)
    return found


def dark_share(
    place: Matrix,
    light_space: Matrix,
    size: int,
    models: Sequence[Matrix],
    bias: Matrix,
    radius: int = 0,
) -> Matrix:
    """How dark a shadow map made by rays tells places: the share of (2 radius + 1)² texels around
    each that say so.

    Args:
        place, light_space, size, models: as in `nearest_depths`.
        bias: of each place, in depth.
        radius: texels to either side.

    >>> behind_and_before = np.array([(0.1, 0.2, 0.9), (0.1, 0.2, -0.9)])
    >>> dark_share(behind_and_before, np.eye(4), 4, [np.eye(4)], np.zeros(2)).tolist()
    [1.0, 0.0]
    """
    depth = 0.5 * (place @ light_space[2, :3] + light_space[2, 3]) + 0.5
    around = range(-radius, radius + 1)
    told = [
        (depth <= 1.0) & (depth - bias > nearest_depths(place, light_space, size, models, (x, y)))
        for x in around
        for y in around
    ]
    share: Matrix = np.mean(told, axis=0)
    return share


def told_otherwise(
    light_space: Matrix, sun: ArrayLike, models: Sequence[Matrix], radius: int = 0
) -> Callable[..., float]:
    """A statistic: the share of places that face the sun of which a shadow map tells something else
    than one made by rays, of the same texels with the same bias; `at_edges`.

    Args:
        light_space, models, radius: as in `dark_share`.
        sun: towards the light, (3,).

    Returns:
        a function of the shadow, the places, their normals (0 where nothing is drawn), the map's
        size, and its biases: the least one, and the one at grazing light.

    >>> up, above = np.array([[(0.0, 0.0, -1.0)]]), np.array([[(0.1, 0.2, -0.9)]])
    >>> told = told_otherwise(np.eye(4), (0.0, 0.0, -1.0), [np.eye(4)])
    >>> told(np.ones((1, 1, 1)), above, up, 4, (0.0, 0.0))
    1.0
    """
    towards = np.asarray(sun, np.float64) / np.linalg.norm(sun)

    def share(
        shadow: Matrix,
        place: Matrix,
        upright: Matrix,
        size: Any,
        biases: Any,
        subpixel_step: float = 2.0**-8,
    ) -> float:
        cosine = upright @ towards
        bias = np.maximum(biases[1] * (1.0 - cosine), biases[0])
        dark = dark_share(place, light_space, int(size), models, bias, radius)
        differs = np.abs(dark - shadow[..., 0]) > 0.5 / (2 * radius + 1) ** 2
        return at_edges(float(np.mean(differs[cosine > 0.0])), subpixel_step)

    return share


def hidden_share(eye: ArrayLike, models: Sequence[Matrix], step: int = 1) -> Callable[..., float]:
    """A statistic of a picture: the share of places in it that a box hides from the eye. A depth
    test that works leaves none, but for pixels at the very edges; see `at_edges`.

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

    def share(FragColor: Matrix, place: Matrix, subpixel_step: float = 2.0**-8) -> float:
        drawn, places = FragColor[::step, ::step, 3] > 0.0, place[::step, ::step, :3]
        to_eye = np.asarray(eye, np.float64) - places
        hidden = blocked(places[drawn], to_eye[drawn], models, reach=1.0)
        return at_edges(float(hidden.mean()), subpixel_step)

    return share


def against_rays(
    statistic: Callable[[Matrix, NDArray[np.bool_]], float],
    light: ArrayLike,
    models: Sequence[Matrix],
    *,
    lamp: bool = False,
) -> Callable[[Matrix, Matrix, Matrix], float]:
    """A statistic of the places that face the light: of what a shadow map says there, and rays.

    Args:
        statistic: of the map's answers, 0…1, and whether each place is blocked, both (n,).
        light: towards the sun, (3,); of a lamp its place.
        models: the boxes' matrices.
        lamp: whether the light is a lamp.

    Returns:
        a function of the shadow, the places and their normals (0 where nothing is drawn).

    >>> up, above = np.array([[(0.0, 0.0, -1.0)]]), np.array([[(0.1, 0.2, -0.9)]])
    >>> against_rays(told_wrongly, (0.0, 0.0, -1.0), [np.eye(4)])(np.ones((1, 1, 1)), above, up)
    1.0
    """

    def found(shadow: Matrix, place: Matrix, upright: Matrix) -> float:
        towards = np.asarray(light) - place if lamp else np.asarray(light)
        there = (upright * towards).sum(axis=-1) > 0.0
        seen = towards[there] if lamp else towards
        truth = blocked(place[there], seen, models, reach=1.0 if lamp else np.inf)
        return statistic(shadow[..., 0][there].astype(np.float64), truth)

    return found


def told_wrongly(shadow: Matrix, truth: NDArray[np.bool_]) -> float:
    """The share of places that a shadow map tells wrongly; more than 0.5 is dark.

    >>> told_wrongly(np.array([1.0, 0.0]), np.array([False, False]))
    0.5
    """
    return float(np.mean((shadow > 0.5) != truth))


def rms_error(shadow: Matrix, truth: NDArray[np.bool_]) -> float:
    """Root mean square of the difference between a shadow map and rays.

    >>> rms_error(np.array([1.0, 0.0]), np.array([False, False])) == 0.5**0.5
    True
    """
    return float(np.sqrt(np.mean((shadow - truth) ** 2)))


def wrongly_dark(shadow: Matrix, truth: NDArray[np.bool_]) -> float:
    """The share of truly lit places that a shadow map darkens: shadow acne.

    >>> wrongly_dark(np.array([1.0, 0.0, 1.0, 0.0]), np.array([False, False, True, False]))
    0.3333333333333333
    """
    return float(np.mean(shadow[~truth] > 0.5))


def wrongly_bright(shadow: Matrix, truth: NDArray[np.bool_]) -> float:
    """The share of truly shadowed places that a shadow map leaves lit: what too large a bias does.

    >>> wrongly_bright(np.array([1.0, 0.0, 1.0, 0.0]), np.array([True, True, True, False]))
    0.3333333333333333
    """
    return float(np.mean(shadow[truth] <= 0.5))
