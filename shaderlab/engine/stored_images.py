"""Stores what scenes drew, so that two drivers' values can be compared afterwards."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from shaderlab.files import replacing
from shaderlab.model.frame import Array, Image


def save(folder: Path, case_id: str, variant: str, images: Mapping[tuple[str, str], Image]) -> None:
    """Store a scene's images as "pass.output", uncompressed: they are read once and deleted.

    Raises:
        OSError: they can't be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    arrays = {".".join(key): image.values for key, image in images.items()}
    with replacing(_file(folder, case_id, variant)) as draft, draft.open("wb") as file:
        np.savez(file, **arrays)  # type: ignore[arg-type]


def digest(values: Array) -> str:
    """A digest of an array's values, type and shape; zeros of both signs differ."""
    found = hashlib.blake2s(f"{values.dtype.str}{values.shape}".encode(), digest_size=12)
    found.update(np.ascontiguousarray(values).data)
    return found.hexdigest()


def load(folder: Path, case_id: str, variant: str) -> dict[str, Array]:
    """The images that `save` stored; empty if the scene was not drawn."""
    try:
        with np.load(_file(folder, case_id, variant), allow_pickle=False) as stored:
            return {name: stored[name] for name in stored.files}
    except FileNotFoundError:
        return {}


def _file(folder: Path, case_id: str, variant: str) -> Path:
    name = hashlib.blake2s(os.fsencode(f"{case_id}\0{variant}")).hexdigest()[:24]
    return folder / f"{name}.npz"
