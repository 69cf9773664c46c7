"""The lab's own cases, loaded once for all tests of a process."""

from __future__ import annotations

from functools import cache

from shaderlab.catalogue import Catalogue


@cache
def shipped() -> Catalogue:
    """The catalogue. Cases can't be changed, so tests may share them."""
    return Catalogue.shipped()
