"""Files that are written whole or not at all, and paths as people read them."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

from shaderlab.errors import ShaderlabError

# Most pieces of a page are a word, some a picture.
_PIECES_PER_WRITE = 32


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A path in the same folder to write to, which replaces `path` when the block ends.

    If the block raises, what it wrote is removed and a file that was there stays. The suffix is
    the same; the rest of the name is unique, so that several processes can write at once. The
    block may also make a symbolic link, or a folder where there is none yet.

    Raises:
        OSError: `path` can't be replaced.
    """
    target = Path(path)
    # Not mkstemp: only their owner can read its files, and reports are for sharing.
    draft = target.with_name(f".{target.stem}.{os.urandom(6).hex()}{target.suffix}")
    try:
        yield draft
        os.replace(draft, target)
    finally:
        if draft.is_dir() and not draft.is_symlink():
            shutil.rmtree(draft, ignore_errors=True)
        else:
            draft.unlink(missing_ok=True)


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write a file whole or not at all.

    Raises:
        OSError: it can't be written.
    """
    with replacing(path) as draft:
        draft.write_bytes(data)


def write_text(path: str | Path, text: str | Iterable[str]) -> None:
    """Write UTF-8 text, in one string or piece by piece, whole or not at all.

    Missing folders are made. Lone surrogates (file names in another encoding) are written as
    question marks.

    Raises:
        ShaderlabError: the folder or the file can't be written.
    """
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with replacing(target) as draft, draft.open("wb") as file:
            pieces = iter((text,) if isinstance(text, str) else text)
            while some := list(islice(pieces, _PIECES_PER_WRITE)):
                file.write("".join(some).encode("utf-8", errors="replace"))
    except OSError as error:
        raise ShaderlabError(
            f"can't write the file ({error.strerror or error})",
            file=target,
            remedy="check that the folder may be written to and has room",
        ) from error


def display_path(path: str | Path, line: int | None = None) -> str:
    """A path, or `path:line`, as people read it: relative if it is below the working directory.

    A relative path stays as it is.
    """
    shown = str(path)
    if os.path.isabs(shown):
        try:
            relative = os.path.relpath(shown)
        except ValueError:  # another drive
            relative = os.pardir
        if not relative.startswith(os.pardir):
            shown = relative
    return shown if line is None else f"{shown}:{line}"
