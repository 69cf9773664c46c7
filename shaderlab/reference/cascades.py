"""Cascaded shadow maps: each slice of the view's depth has a map of its own.

Sources: F. Zhang, H. Sun, L. Xu, L. K. Lun, "Parallel-Split Shadow Maps for Large-scale Virtual
Environments", VRCIA 2006, equations 2 (logarithmic), 4 (uniform) and 6 (practical); R. Dimitrov,
"Cascaded Shadow Maps", NVIDIA 2007 (a map fitted to each slice of the view).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from shaderlab.glslmath import Value, where
from shaderlab.reference.transforms import Matrix, orthographic


def split_distances(near: float, far: float, count: int, blend: float) -> list[float]:
    """The far ends of all slices: λ n (f/n)^(i/N) + (1 − λ)(n + (f − n) i/N), i = 1 … N.

    Args:
        near, far: n and f, of the view, 0 < n < f.
        count: N, how many slices.
        blend: λ: 0 for slices of equal depth, 1 for slices whose depths grow by a constant ratio.

    >>> [[round(d, 4) for d in split_distances(0.5, 60.0, 3, b)] for b in (0.0, 1.0)]
    [[20.3333, 40.1667, 60.0], [2.4662, 12.1644, 60.0]]
    """
    steps = [k / count for k in range(1, count + 1)]
    return [
        blend * near * (far / near) ** part + (1.0 - blend) * (near + (far - near) * part)
        for part in steps
    ]


def cascade_index(depth: Value, splits: Sequence[Value]) -> Value:
    """The slice that a depth lies in: how many splits, without the last, it has reached.

    >>> [float(cascade_index(d, [2.0, 5.0, 9.0])) for d in (1.0, 2.0, 7.0, 12.0)]
    [0.0, 1.0, 2.0, 2.0]
    """
    index: Value = 0.0
    for split in splits[:-1]:
        index = index + where(depth >= split, 1.0, 0.0)
    return index


def slice_corners(view: Matrix, projection: Matrix, near: float, far: float) -> Matrix:
    """The eight corners of a slice of a perspective view, in the world, (8, 3).

    Args:
        view, projection: the camera's.
        near, far: depths where the slice begins and ends.

    >>> from shaderlab.reference.transforms import perspective
    >>> found = slice_corners(np.eye(4), perspective(np.pi / 2, 1.0, 0.1, 9.0), 1.0, 2.0)
    >>> found[[0, 7]].round(9).tolist()
    [[-1.0, -1.0, -1.0], [2.0, 2.0, -2.0]]
    """
    right, up = 1.0 / projection[0, 0], 1.0 / projection[1, 1]
    local = [
        (x * right * d, y * up * d, -d, 1.0) for d in (near, far) for y in (-1, 1) for x in (-1, 1)
    ]
    corners: Matrix = np.array(local) @ np.linalg.inv(view).T
    return corners[:, :3]


def fitted(light_view: Matrix, corners: Any, depths: tuple[float, float]) -> Matrix:
    """A light-space matrix whose map fits tightly around some corners.

    Args:
        light_view: the view matrix of the light.
        corners: (n, 3), in the world.
        depths: where the map begins and ends along the light, so that it includes casters outside
            the slice.

    >>> box = [(-1.0, -2.0, 0.0), (3.0, 2.0, 0.0)]
    >>> (fitted(np.eye(4), box, (-5.0, 5.0)) @ (3.0, 2.0, 0.0, 1.0)).tolist()
    [1.0, 1.0, 0.0, 1.0]
    """
    seen = np.asarray(corners, float) @ light_view[:3, :3].T + light_view[:3, 3]
    (left, bottom, _), (right, top, _) = seen.min(axis=0), seen.max(axis=0)
    return orthographic(left, right, bottom, top, *depths) @ light_view
