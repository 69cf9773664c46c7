"""What scenes drew, kept as files, so that two drivers' values can be compared afterwards."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from shaderlab.frame import Array, Image


def save(folder: Path, case_id: str, variant: str, images: Mapping[tuple[str, str], Image]) -> None:
    """Keep a scene's images, by "pass.output", uncompressed: they are read once and thrown away."""
    folder.mkdir(parents=True, exist_ok=True)
    arrays = {".".join(key): image.values for key, image in images.items()}
    np.savez(_file(folder, case_id, variant), **arrays)  # type: ignore[arg-type]


def load(folder: Path, case_id: str, variant: str) -> dict[str, Array]:
    """The images that `save` kept; none if the scene did not come to draw."""
    try:
        with np.load(_file(folder, case_id, variant), allow_pickle=False) as kept:
            return {name: kept[name] for name in kept.files}
    except FileNotFoundError:
        return {}


def _file(folder: Path, case_id: str, variant: str) -> Path:
    name = hashlib.blake2s(f"{case_id}\0{variant}".encode()).hexdigest()[:24]
    return folder / f"{name}.npz"
