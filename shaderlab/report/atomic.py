"""Text files that are written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterable
from itertools import islice
from pathlib import Path

from shaderlab.errors import ShaderlabError

# Most pieces are a word, some are a picture.
_TOGETHER = 32


def write_text(path: Path, text: str | Iterable[str]) -> None:
    """Write UTF-8 text, whole or piece by piece.

    A file that was there stays as it is unless all of it was written.

    Missing folders are made. Lone surrogates (file names in another encoding) are written as
    question marks.

    Raises:
        ShaderlabError: the folder or the file can't be written.
    """
    temporary = path.with_name(f".{path.name}.{os.urandom(6).hex()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with temporary.open("wb") as file:
                pieces = iter((text,) if isinstance(text, str) else text)
                while some := list(islice(pieces, _TOGETHER)):
                    file.write("".join(some).encode("utf-8", errors="replace"))
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise ShaderlabError(
            f"can't write the file ({error.strerror or error})",
            file=path,
            remedy="check that the folder may be written to and has room",
        ) from error
