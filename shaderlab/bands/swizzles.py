"""Components by GLSL's names, as attributes: `v.xyz`, `color.rgb`, `uv.st`."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

SETS = ("xyzw", "rgba", "stpq")


@lru_cache(maxsize=256)
def components(names: str, size: int) -> list[int] | None:
    """The components that GLSL's letters name, of one set and of `size`; None for other words."""
    for letters in SETS:
        if names and set(names) <= set(letters[:size]):
            return [letters.index(name) for name in names]
    return None


class Swizzled:
    """A value whose components have GLSL's names: read-only, any order, repeated or not."""

    __slots__ = ()

    def __getattr__(self: Any, names: str) -> Any:
        # Words that can't be a swizzle don't ask for the shape, which may be what is missing.
        found = None if components(names, 4) is None else components(names, self.shape[-1])
        if found is None:
            raise AttributeError(self._without(names))
        return self[..., found]

    def _without(self: Any, names: str) -> str:
        """What to say of a word that is no swizzle of this value."""
        if components(names, 4) is None:
            return f"{type(self).__name__} has no attribute {names!r}"
        size = self.shape[-1] if self.shape else 1
        kind = f"a vec{size} has" if size > 1 else "a float has"
        return f"{kind} no .{names}"


class Vector(Swizzled, np.ndarray):
    """A float64 array whose last axis is a vector's components.

    >>> np.array([1.0, 2.0, 3.0]).view(Vector).zx.tolist()
    [3.0, 1.0]
    """


def as_vector(result: Any, *values: Any) -> Any:
    """The result of a function that forgets it, as a `Vector` if one of its values is one."""
    if isinstance(result, np.ndarray) and any(isinstance(value, Vector) for value in values):
        return result.view(Vector)
    return result
