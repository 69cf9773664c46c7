"""Pictures of where two drivers differ."""

from __future__ import annotations

import numpy as np

from shaderlab.cli.compare_drivers import shade_distances


def test_pictures_of_differences_grow_darker_and_small() -> None:
    apart = np.zeros((2, 641))
    apart[0, 640], apart[1, 0], apart[0, 5] = np.inf, 1.0, 3000.0
    made = shade_distances(apart)
    assert made.shape == (1, 214) and made[0, 213] == 4
    assert (made[0, 0], made[0, 1], made[0, 2]) == (1, 2, 0)
