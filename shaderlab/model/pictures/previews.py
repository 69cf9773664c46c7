"""Small copies of picture files, for the page: made once, when the picture is drawn.

`picture.png` has `picture@320.png` beside it, at most 320 pixels in each direction.
"""

from __future__ import annotations

from pathlib import Path


def preview(path: str | Path, side: int) -> Path:
    """A PNG file's copy of at most `side` pixels, or the file itself if there is none."""
    original = Path(path)
    if not side:
        return original
    copy = copy_path(original, side)
    return copy if copy.is_file() else original


def copy_path(path: Path, side: int) -> Path:
    """Where the copy of at most `side` pixels of a PNG file is."""
    return path.with_name(f"{path.stem}@{side}.png")
