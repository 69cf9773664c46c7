"""The picture files of a run: what a case looks like, and what its checks saw."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from shaderlab import pictures
from shaderlab.frame import Array, Image
from shaderlab.gl import formats

JUDGED_SIDE = 192


@dataclass(frozen=True)
class Shown:
    """Picture files by what they show, relative to the run's folder, and how to read them."""

    files: Mapping[str, str] = field(default_factory=dict)
    captions: Mapping[str, str] = field(default_factory=dict)


class Album:
    """Writes pictures below `folder`/images; without a folder it writes nothing.

    Names are made of the case's id, the variant and a label, and always end up inside the folder.
    """

    def __init__(self, folder: Path | None, case_id: str, variant: str) -> None:
        self._folder = folder
        self._stem = f"{_safe(case_id)}--{_safe(variant)}"

    def portrait(self, image: Image) -> Shown:
        """The case's picture."""
        if self._folder is None:
            return Shown()
        display = pictures.to_display(_colours(image))
        return Shown(
            {"picture": self._save("picture", display.image, 256)}, {"picture": display.caption}
        )

    def judged(self, label: str, arrays: Mapping[str, Array]) -> Shown:
        """A check's measured and reference values in common colours, and the distance."""
        if self._folder is None or not arrays:
            return Shown()
        span = _common_range(arrays["measured"], arrays["reference"])
        files, captions = {}, {}
        for what in ("measured", "reference"):
            display = pictures.to_display(arrays[what], value_range=span)
            files[what] = self._save(f"{label}-{what}", display.image, JUDGED_SIDE)
            captions[what] = display.caption
        distance = arrays["distance"]
        seen = pictures.distance_picture(distance, np.abs(distance) > 1.0, min_side=JUDGED_SIDE)
        files["distance"] = self._save(f"{label}-distance", seen, JUDGED_SIDE)
        return Shown(files, captions)

    def _save(self, label: str, image: Array, side: int) -> str:
        assert self._folder is not None
        relative = f"images/{self._stem}--{_safe(label)}.png"
        path = self._folder / relative
        path.parent.mkdir(parents=True, exist_ok=True)
        pictures.save_png(path, image, min_side=side)
        return relative


def _colours(image: Image) -> Array:
    """The image without alpha: what a window would show."""
    return image.values[..., :3] if formats.COLOR[image.format].components == 4 else image.values


def _common_range(measured: Array, reference: Array) -> tuple[float, float] | None:
    """One range of values for both pictures, so that equal colours mean equal values."""
    if measured.shape[2] != 1:
        return None
    both = np.concatenate([np.ravel(measured), np.ravel(reference)]).astype(np.float64)
    finite = both[np.isfinite(both)]
    return (float(finite.min()), float(finite.max())) if finite.size else None


def _safe(word: str) -> str:
    """`word` as part of a file name; different words stay different."""
    plain = re.sub(r"[^A-Za-z0-9.]+", "-", word).strip("-.")[:80]
    if plain == word:
        return plain
    return f"{plain}-{hashlib.blake2s(word.encode(), digest_size=3).hexdigest()}"
