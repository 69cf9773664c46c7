"""Compiling with a memory on disk: a program that was compiled before, by the same compilers, from
the same text, is not compiled again.

What is kept is the whole result, refusals and all their words too, under a key of everything that
it is made from. What a crash or a time limit ended gave no result, and is never kept; neither is
what the compilers' commands said, since nothing here can tell which libraries those load.
"""

from __future__ import annotations

import functools
import hashlib
import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path

from shaderlab.glsl.compile import Compile, Compiled, compile_program, in_order
from shaderlab.glsl.engines import COMMAND_VARIABLE, choose
from shaderlab.glsl.fingerprint import compilers
from shaderlab.glsl.interface import Interface
from shaderlab.glsl.packing import Package, packed, unpacked
from shaderlab.glsl.sources import Source
from shaderlab.glsl.store import Store

FOLDER_VARIABLE = "SHADERLAB_CACHE_DIR"


def cache_folder() -> Path | None:
    """Where compiled programs are kept: in the folder that SHADERLAB_CACHE_DIR names, else where
    the user's caches are. None where the variable is empty, or there is no such place."""
    named, base = os.environ.get(FOLDER_VARIABLE), os.environ.get("XDG_CACHE_HOME", "")
    if named == "":
        return None
    try:
        if named is not None:
            return Path(named).expanduser().absolute() / "compiled"
        caches = Path(base) if os.path.isabs(base) else Path.home() / ".cache"
    except (OSError, RuntimeError):  # no such user, no home, no working directory
        return None
    return caches / "shaderlab" / "compiled"


def compiler() -> Compile:
    """What compiles programs: `compile_program`, and before it a look into the cache."""
    folder = cache_folder()
    return compile_program if folder is None else _keeper(folder).compile


@functools.cache
def _keeper(folder: Path) -> Keeper:
    store = Store(folder)
    return Keeper(store, functools.partial(compilers, store))


class Keeper:
    """Compiles each program once and keeps what came of it.

    Args:
        store: where.
        fingerprint: what stands for the compilers; asked once, when a program first comes.
            Nothing is kept where it is None.
    """

    def __init__(self, store: Store, fingerprint: Callable[[], str | None]) -> None:
        self._store = store
        self._fingerprint = functools.cache(fingerprint)

    def compile(self, stages: Sequence[Source], targets: Sequence[str]) -> Compiled:
        """As `compile_program`, with the engine that there is.

        Raises:
            ShaderError: as `compile_program`.
        """
        fingerprint = None if os.environ.get(COMMAND_VARIABLE) else self._fingerprint()
        if fingerprint is None:
            return compile_program(stages, targets)
        ordered = tuple(in_order(stages, targets))
        key = key_of(ordered, targets, fingerprint)
        return self._known(key, ordered, targets) or self._anew(key, ordered, targets)

    def _known(
        self, key: str, ordered: tuple[Source, ...], targets: Sequence[str]
    ) -> Compiled | None:
        data = self._store.get(key)
        if data is None:
            return None
        try:
            package = unpacked(data)
        except ValueError:
            return None

        def declared() -> Interface | None:
            if "opengl" in targets:
                return package.interface
            return self.compile(ordered, ("glsl", "opengl")).interface

        return Compiled(package.verdicts, package.spirv, package.logs, ordered, declared)

    def _anew(self, key: str, ordered: tuple[Source, ...], targets: Sequence[str]) -> Compiled:
        engine = choose()
        compiled = compile_program(ordered, targets, engine=engine)
        if engine.name == "library":
            interface = compiled.interface if "opengl" in targets else None
            package = Package(compiled.verdicts, compiled.spirv, compiled.logs, interface)
            self._store.put(key, packed(package))
        return compiled


def key_of(ordered: Sequence[Source], targets: Sequence[str], fingerprint: str) -> str:
    """The key of a program: a digest of each stage's text with its includes, of the names and the
    lines that messages give, of the targets and of what compiles."""
    stages = [
        [s.stage, s.name, s.path, s.text, s.stripped, s.lines.spans, s.parts] for s in ordered
    ]
    whole = json.dumps([fingerprint, list(targets), stages])
    return hashlib.sha256(whole.encode("ascii")).hexdigest()
