"""Where a case's shaders are searched for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from shaderlab.compiler.sources import Shaders
from shaderlab.discovery import data_folder


def shaders_of(folder: Path, overrides: Mapping[str, str | Path]) -> Shaders:
    """The shaders of the cases in `folder`: those beside them, in shaders/ there, the shipped ones.

    Args:
        folder: where the case file is; a shipped case sees the shipped shaders alone.
        overrides: texts or files to take in a shader's place, by its name.
    """
    shipped = data_folder("shaders")
    inside = folder.resolve().is_relative_to(data_folder("cases").resolve())
    own = [] if inside else [p for p in (folder, folder / "shaders") if p.is_dir()]
    return Shaders([*own, shipped], overrides=dict(overrides))
