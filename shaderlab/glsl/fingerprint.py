"""What stands for the compilers in a cache's keys: a digest of their libraries and of the lab's own
code around them, so that no answer of another compiler, or of another lab, is taken for theirs.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from shaderlab.errors import ShaderError
from shaderlab.glsl.library import files
from shaderlab.glsl.store import Store

# Files that were written when this process had begun may be others than those that it works with.
_BEGUN = time.time()
_GRAIN = 2.0  # seconds, more than a file system's clock ticks


def compilers(store: Store) -> str | None:
    """The digest of everything that compiles; None where that can't be told: the compilers are
    no libraries, or a file has only just been written."""
    here = Path(__file__).parent
    own = [*sorted(here.glob("*.py")), here.parent / "records.py", here.parent / "errors.py"]
    if Path(__file__) not in own:  # an installation without sources
        return None
    try:
        return digest_of([*files(), *own], store)
    except (OSError, ShaderError):
        return None


def digest_of(paths: Sequence[Path], store: Store, begun: float = _BEGUN) -> str | None:
    """One digest of the files' contents; None where one of them was changed later than shortly
    before the time `begun`. The store remembers it for as long as no file is touched.

    Raises:
        OSError: a file can't be read.
    """
    known = [os.stat(path) for path in paths]
    if max(stat.st_ctime for stat in known) > begun - _GRAIN:
        return None
    told = [
        [str(path), stat.st_dev, stat.st_ino, stat.st_size, stat.st_mtime_ns, stat.st_ctime_ns]
        for path, stat in zip(paths, known, strict=True)
    ]
    key = hashlib.sha256(json.dumps(["files", told]).encode()).hexdigest()
    remembered = store.get(key)
    if remembered is not None:
        return remembered.decode("ascii", "replace")
    whole = hashlib.sha256(json.dumps([sys.byteorder, sys.implementation.cache_tag]).encode())
    for path in paths:
        with open(path, "rb") as file:
            whole.update(hashlib.file_digest(file, "sha256").digest())
    digest = whole.hexdigest()
    store.put(key, digest.encode("ascii"))
    return digest
