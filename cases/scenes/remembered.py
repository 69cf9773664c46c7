"""Meshes that many cases draw, made once a process."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import ParamSpec

from shaderlab.assets.meshes import Geometry

P = ParamSpec("P")

MOST = 32
"""Meshes kept of each kind, so that a loop over sizes fills no memory."""


def remembered(make: Callable[P, Geometry]) -> Callable[P, Geometry]:
    """Caches `make` by its arguments; each call returns arrays of its own.

    >>> calls = []
    >>> @remembered
    ... def one(size=1.0):
    ...     calls.append(size)
    ...     return quad(size)
    >>> from shaderlab.assets.meshes import quad
    >>> one(2.0)["indices"][0] = 3
    >>> int(one(2.0)["indices"][0]), calls
    (0, [2.0])
    """
    kept = lru_cache(maxsize=MOST, typed=True)(make)

    @wraps(make)
    def again(*args: P.args, **kwargs: P.kwargs) -> Geometry:
        try:
            made = kept(*args, **kwargs)  # type: ignore[arg-type]
        except TypeError:  # a list among the arguments; or it is wrong, which is said again
            return make(*args, **kwargs)
        return {
            "attributes": {name: array.copy() for name, array in made["attributes"].items()},
            "indices": made["indices"].copy(),
        }

    return again
