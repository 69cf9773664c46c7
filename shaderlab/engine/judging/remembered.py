"""Bands that are kept while many variations of one shader are judged.

A shader that is changed and judged again by the same formula, on the same inputs, has the same
band; evaluating it is most of what judging costs.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.model.frame import Array, Texels

from .inputs import Inputs

if TYPE_CHECKING:
    from .reference_bands import ReferenceBand


class RememberedBands:
    """Bands by reference and the content of its inputs. The first ones stay; when the limit is
    reached, further ones are not kept.

    Args:
        limit: bytes of bounds that may be kept.
    """

    def __init__(self, limit: int = 1 << 28) -> None:
        self._room = limit
        self._known: dict[tuple[Any, ...], ReferenceBand] = {}

    @contextmanager
    def in_use(self) -> Iterator[None]:
        """Remember bands for a while."""
        token = _REMEMBERED.set(self)
        try:
            yield
        finally:
            _REMEMBERED.reset(token)

    def get(self, key: tuple[Any, ...]) -> ReferenceBand | None:
        return self._known.get(key)

    def keep(self, key: tuple[Any, ...], band: ReferenceBand) -> None:
        size = band.low.nbytes + band.high.nbytes
        if size <= self._room:
            self._room -= size
            self._known[key] = band


_REMEMBERED: ContextVar[RememberedBands | None] = ContextVar("remembered", default=None)


def remembered_bands() -> RememberedBands | None:
    """The bands that are in use now, if any are."""
    return _REMEMBERED.get()


def digest(inputs: Inputs, asked: Mapping[str, list[str]]) -> bytes:
    """Tells inputs apart by the content of all that a formula asks for."""
    found = hashlib.blake2b(digest_size=16)
    for parameter, names in asked.items():
        found.update(repr((parameter, names, [n in inputs.arrays for n in names])).encode())
        for name in names:
            texels = inputs.textures.get(name)
            arrays: tuple[Array, ...]
            if texels is None:
                arrays = (inputs.exact[name],)
            else:
                arrays = (texels.values, *texels.smaller)
                found.update(repr(_sampling(texels)).encode())
            for array in arrays:
                found.update(f"{array.dtype} {array.shape} {name in inputs.each}".encode())
                found.update(np.ascontiguousarray(array).data)
    return found.digest()


def _sampling(texels: Texels) -> dict[str, Any]:
    """How a texture is sampled: all of it but its levels."""
    return {n: v for n, v in vars(texels).items() if n not in ("values", "smaller")}
