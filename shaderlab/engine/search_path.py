"""Where a case's shaders are searched for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from shaderlab.compiler.sources import Shaders
from shaderlab.settings import settings_of

from .discovery import data_folder


def shaders_of(
    folder: Path,
    overrides: Mapping[str, str | Path],
    include: Sequence[Path] = (),
    renames: Mapping[str, str] | None = None,
) -> Shaders:
    """The shaders of the cases in `folder`: those of their project, the shipped ones.

    Args:
        folder: where the case file is; a shipped case sees the shipped shaders alone.
        overrides: texts or files to take in a shader's place, by its name.
        include: further folders, which come after the project's own.
        renames: names in the files of `overrides`, and what they are called instead.

    Raises:
        UsageError: the project's settings are wrong.
    """
    shipped = data_folder("shaders")
    inside = folder.resolve().is_relative_to(data_folder("cases").resolve())
    own = () if inside else (*settings_of(folder).shader_folders(folder), *include)
    return Shaders([*own, shipped], overrides=dict(overrides), renames=renames)
