"""Bytes by key in a folder. Nothing here raises: what can't be read is absent, what can't be
written is not stored.

Each entry is a file that is written whole or not at all, so several processes can share a folder.
It begins with a checksum of its key and content; a file that was cut short, changed or renamed is
absent. When the folder outgrows its limit the entries that were least recently used go first.
"""

import functools
import hashlib
import json
import os
import sys
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from shaderlab.errors import Diagnostic, ShaderError, Verdict
from shaderlab.files import cache_root, open_regular, write_bytes

from .compile import Compile, Compiled, compile_program, keep_literals, order_stages, with_interface
from .glslang import files, link
from .sources import Source

LIMIT = 256 << 20
_BLOCK = 4096  # bytes of disk that the smallest file takes
_CHECKSUM = 32
_FOLDERS = 16
_HOUR = 3600.0
# Tells backup programs that this is a cache: Cache Directory Tagging Specification, B. Ford, 2004.
_SIGNATURE = "Signature: 8a477f597d28d172789f06886806bc55\n"


class Store:
    """A folder of entries, created when the first one is put into it, in sixteen folders by the
    first digit of their keys. `limit` is bytes of disk for all entries, exceeded by a few at most:
    each of the sixteen may take a sixteenth of it, and larger entries are not stored."""

    def __init__(self, folder: Path, limit: int = LIMIT) -> None:
        self.folder = folder
        self._name = str(folder)  # joining strings is several times as fast as joining paths
        self._share = limit // _FOLDERS

    def get(self, key: str) -> bytes | None:
        """Return the content stored under a hexadecimal key, or None."""
        path = self._path(key)
        try:
            with open(open_regular(path), "rb") as file:
                stat = os.fstat(file.fileno())
                data = file.read() if stat.st_size <= self._share else b""
        except OSError:
            return None
        content = data[_CHECKSUM:]
        if data[:_CHECKSUM] != _checksum(key, content):
            return None
        if time.time() - stat.st_mtime > _HOUR:  # so the time of use is known to the hour
            with suppress(OSError):
                os.utime(path)
        return content

    def put(self, key: str, content: bytes) -> None:
        """Store content under a hexadecimal key, removing old entries to make room."""
        data = _checksum(key, content) + content
        if _on_disk(len(data)) > self._share:
            return
        path = self._path(key)
        folder = os.path.dirname(path)
        with suppress(OSError):
            if not os.path.isdir(folder):
                self._make(folder)
            write_bytes(path, data)
            if key[1:3] == "00":  # one time in 256, since it looks at every file of the folder
                self._trim(folder)

    def _path(self, key: str) -> str:
        return os.path.join(self._name, key[:1], key[1:])

    def _make(self, folder: str) -> None:
        if not self.folder.is_dir():
            self.folder.mkdir(parents=True, exist_ok=True)
            (self.folder / "CACHEDIR.TAG").write_text(_SIGNATURE, encoding="ascii")
        os.makedirs(folder, exist_ok=True)

    def _trim(self, folder: str) -> None:
        """Shrink a folder to 7/8 of its share, and remove drafts of processes that died."""
        found = sorted(_files(folder))
        total = sum(size for _, size, _ in found)
        for used, size, path in found:
            abandoned = os.path.basename(path).startswith(".") and time.time() - used > _HOUR
            if total > self._share * 7 // 8 or abandoned:
                with suppress(FileNotFoundError):
                    os.unlink(path)
                total -= size


def _files(folder: str) -> Iterator[tuple[float, int, str]]:
    """Yield a folder's files: when each was last used, the bytes of disk it takes, its path."""
    with os.scandir(folder) as entries:
        for entry in entries:
            with suppress(FileNotFoundError):  # another process was faster
                stat = entry.stat(follow_symlinks=False)
                yield stat.st_mtime, _on_disk(stat.st_size), entry.path


def _on_disk(size: int) -> int:
    return -(-size // _BLOCK) * _BLOCK


def _checksum(key: str, content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_CHECKSUM, key=bytes.fromhex(key)).digest()


_LARGEST = 64 << 20  # bytes that an entry may inflate to
# A file written after this process started may differ from what the process has loaded.
_STARTED = time.time()
_CLOCK_TICK = 2.0  # seconds; coarser than any file system's clock


def cache_folder() -> Path | None:
    """Return the cache's folder below `shaderlab.files.cache_root`; None if there is none."""
    root = cache_root()
    return None if root is None else root / "compiled"


def cached_compiler() -> Compile:
    """Return `compile_program`, behind the compile cache where there is one."""
    folder = cache_folder()
    return compile_program if folder is None else _cache(folder).compile


def compile_with_lines(source: Source) -> Compiled:
    """Compile one stage for OpenGL, or for Vulkan if only that takes it, behind the compile cache;
    its module says which line of the text each instruction comes from, and computes constant
    expressions itself (see `keep_literals`) where the text compiles so. Raises ShaderError: as
    `compile_program`."""
    return _cache(cache_folder()).compile_with_lines(source)


def _compile_with_lines(source: Source) -> Compiled:
    # First as it is: no other text of what would crash the compiler, or is no valid module.
    compiled = compile_program([source], ("opengl",))
    if not compiled.ok:
        compiled = compile_program([source], ("opengl", "vulkan"))
    for target in compiled.spirv:
        for text in (keep_literals(source), source):
            linked = link([text], target, lines=True)
            if linked.ok:
                return replace(compiled, spirv={target: linked.modules})
    return replace(compiled, spirv={})


@functools.cache
def _cache(folder: Path | None) -> "CompileCache":
    return CompileCache(Store(folder or Path()), compilers_digest if folder else lambda: None)


class CompileCache:
    """Compiles each program once and stores the result. `compilers` returns a digest of the
    compilers, or None to switch the cache off; it is called once, for the first program."""

    def __init__(self, store: Store, compilers: Callable[[], str | None]) -> None:
        self._store = store
        self._compilers = functools.cache(compilers)

    def compile(self, stages: Sequence[Source], targets: Sequence[str]) -> Compiled:
        ordered = tuple(order_stages(stages, targets))
        return self._get(ordered, targets, targets, lambda: compile_program(ordered, targets))

    def compile_with_lines(self, source: Source) -> Compiled:
        return self._get((source,), ("lines",), (), lambda: _compile_with_lines(source))

    def _get(
        self,
        ordered: tuple[Source, ...],
        words: Sequence[str],
        targets: Sequence[str],
        compute: Callable[[], Compiled],
    ) -> Compiled:
        """Return what is stored of these stages under `words`, or compute and store it."""
        compilers = self._compilers()
        if compilers is None:
            return compute()
        key = program_key(ordered, words, compilers)
        try:
            found = decode(self._store.get(key) or b"")
        except ValueError:  # absent, or not an entry
            found = compute()
            self._store.put(key, encode(found))
            return found
        return with_interface(found, ordered, targets, self.compile)


def program_key(ordered: Sequence[Source], targets: Sequence[str], compilers: str) -> str:
    """Return a digest of each stage's text with its includes, of the names and lines that messages
    quote, of the targets and of the compilers."""
    stages = [
        [s.stage, s.name, s.path, s.text, s.stripped, s.lines.spans, s.parts] for s in ordered
    ]
    return _digest([compilers, list(targets), stages])


# What the code around the compilers imports of the lab.
_SHARED = ("errors.py", "files.py")


def compilers_digest() -> str | None:
    """Return a digest of the compilers' libraries and of the lab's code around them.

    None if it is unknown: there are no libraries, or a file has only just been written."""
    here = Path(__file__).parent
    shared = [path for name in _SHARED for path in sorted(here.parent.glob(name))]
    own = [*sorted(here.glob("*.py")), *shared]
    if Path(__file__) not in own:  # an installation without sources
        return None
    try:
        return files_digest([*files(), *own])
    except (OSError, ShaderError):
        return None


def files_digest(paths: Sequence[Path], started: float = _STARTED) -> str | None:
    """Return one digest of the files' contents.

    None if a file was changed after, or just before, the time `started`. Raises OSError: a file
    can't be read."""
    if max(os.stat(path).st_ctime for path in paths) > started - _CLOCK_TICK:
        return None
    contents = [hashlib.sha256(path.read_bytes()).hexdigest() for path in paths]
    return _digest([sys.byteorder, sys.implementation.cache_tag, contents])


def _digest(value: object) -> str:
    return hashlib.sha256(json.dumps(value).encode("ascii")).hexdigest()


def encode(compiled: Compiled) -> bytes:
    """Return a program's verdicts and modules as deflated JSON."""
    plain = lambda value: value.hex() if isinstance(value, bytes) else vars(value)  # noqa: E731
    text = json.dumps([compiled.verdicts, compiled.spirv], default=plain)
    return zlib.compress(text.encode("ascii"), 1)


def decode(data: bytes) -> Compiled:
    """Return the verdicts and modules again. Builds plain data only; nothing in `data` is
    executed. Raises ValueError: the bytes are not an entry."""
    mistakes = zlib.error, ArithmeticError, AttributeError, LookupError, RecursionError, TypeError
    try:
        verdicts, spirv = json.loads(zlib.decompressobj().decompress(data, _LARGEST))
        for each in verdicts:
            each["diagnostics"] = tuple(Diagnostic(**one) for one in each["diagnostics"])
        return Compiled(
            verdicts=tuple(Verdict(**each) for each in verdicts),
            spirv={t: {s: bytes.fromhex(m) for s, m in of.items()} for t, of in spirv.items()},
        )
    except mistakes as error:
        raise ValueError(f"not a compile cache entry: {error}") from error
