"""Tells a project's own files from those of Python, of packages and of the system."""

from __future__ import annotations

import functools
import sysconfig
from pathlib import Path

_SYSTEM = ("/proc", "/dev", "/sys", "/etc")
_OF_TOOLS = frozenset({"__pycache__", ".git", ".hypothesis", ".pytest_cache"})
_LIBRARIES = ("stdlib", "platstdlib", "purelib", "platlib")


def is_own(path: Path) -> bool:
    """Whether a file belongs to a project: not to Python, to a package, to the system, to a tool
    that keeps files of its own there, or to the compile cache."""
    return _OF_TOOLS.isdisjoint(path.parts) and not any(map(path.is_relative_to, _foreign()))


@functools.cache
def _foreign() -> tuple[str | Path, ...]:
    from shaderlab.compiler.compile_cache import cache_folder  # few commands ask

    package = Path(__file__).resolve().parents[2]
    libraries = [sysconfig.get_path(name) for name in _LIBRARIES]
    return (package, *libraries, *_SYSTEM, *filter(None, [cache_folder()]))
