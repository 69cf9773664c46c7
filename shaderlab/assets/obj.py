"""Wavefront OBJ files, through trimesh.

trimesh builds the meshes: it merges corners that agree in position, texture coordinate and normal,
splits polygons into triangles and reads the materials. It supports no relative indices and ignores
errors, so every line is checked first, and its indices are made absolute.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.assets.meshes import Geometry
from shaderlab.errors import AssetError, extra, nearest

MAX_BYTES = 64 << 20
"""The largest file that is read."""

_NUMBERS = {"v": (3, "a position"), "vt": (2, "a texture coordinate"), "vn": (3, "a normal")}
_CORNER = re.compile(r"(-?\d+)(?:/(-?\d+)?(?:/(-?\d+))?)?")
_REPAIR = "export the model again"
_SPELLING = "check the path and its spelling"

Corner = tuple[int, int, int]


@dataclass(frozen=True, kw_only=True)
class Part:
    """All faces of one material.

    Attributes:
        material: its name, "" where the file gives none.
        color: its diffuse colour Kd, three floats; 0.8 where there is none.
        shininess: its specular exponent Ns; 0 where there is none.
        geometry: aPos (n, 3), aNormal (n, 3) of length 1, aTexCoords (n, 2), all float32, and
            indices, three a triangle.
    """

    material: str
    color: tuple[float, float, float]
    shininess: float
    geometry: Geometry


def load_obj(path: str | Path) -> tuple[Part, ...]:
    """An OBJ file's faces by material, in the order in which the materials are first used.

    Corners need normals; texture coordinates are 0 where there are none. Groups, objects and
    smoothing are read over.

    Raises:
        AssetError: the file or its material library is missing or can't be read, a line is cut off
            or malformed, a number is not finite, an index leads nowhere, or there are no faces;
            the message names the file and the line.
    """
    source = Path(path)
    text, names = _checked(source)
    with extra("models", "an OBJ file", source):
        import trimesh

    resolver = trimesh.resolvers.FilePathResolver(str(source.resolve()))
    try:
        made = trimesh.exchange.obj.load_obj(io.StringIO(text), resolver=resolver)
    except Exception as error:  # its parser raises many kinds
        raise AssetError(
            f"trimesh can't read it ({type(error).__name__}: {error})", file=source, remedy=_REPAIR
        ) from error
    found = made.get("geometry") or {names[0] if names else "": made}
    parts = {_material(arrays): _part(arrays) for arrays in found.values()}
    return tuple(parts[name] for name in names if name in parts)


def read_bytes(source: Path, what: str, limit: int, too_large: str) -> bytes:
    """A model's file.

    Args:
        what: a name of its kind, such as "an OBJ file".
        limit: the most bytes that are read.
        too_large: the remedy for a larger file.

    Raises:
        AssetError: it is missing, a folder, unreadable or too large.
    """
    if source.is_dir():
        raise AssetError(f"is a folder, not {what}", file=source, remedy=_SPELLING)
    if not source.is_file():
        message = f"there is no such file ({what} was asked for)"
        raise AssetError(message, file=source, remedy=_SPELLING)
    try:
        if source.stat().st_size > limit:
            message = f"is larger than {limit >> 20} MiB"
            raise AssetError(message, file=source, remedy=too_large)
        return source.read_bytes()
    except OSError as error:
        raise AssetError(f"can't be read: {error.strerror or error}", file=source) from error


def _read_text(source: Path, what: str) -> str:
    try:
        text = read_bytes(source, what, MAX_BYTES, "simplify the model").decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise AssetError(
            f"is no text: byte {error.start} is 0x{error.object[error.start]:02x}",
            file=source,
            remedy=f"see whether this is {what} at all",
        ) from None
    if not text.strip():
        raise AssetError("the file is empty", file=source, remedy=_REPAIR)
    return text


@contextmanager
def at(source: Path, line: int | None = None) -> Iterator[None]:
    """Adds the place to errors that have none."""
    try:
        yield
    except AssetError as error:
        if error.file is not None:
            raise
        raise AssetError(error.message, file=source, line=line, remedy=error.remedy) from None


def _checked(source: Path) -> tuple[str, list[str]]:
    """The text with absolute indices, and the materials in the order of their first use."""
    rows: list[str] = []
    counts = dict.fromkeys(_NUMBERS, 0)
    faces: list[tuple[int, list[Corner]]] = []
    known: dict[str, None] = {}
    used: dict[str, None] = {}
    current = ""
    for line, row in enumerate(_read_text(source, "an OBJ file").splitlines(), start=1):
        word, _, rest = row.split("#")[0].strip().partition(" ")
        with at(source, line):
            if word in _NUMBERS:
                _check_numbers(word, rest.split())
                counts[word] += 1
            elif word == "f":
                corners = [_corner(corner, counts) for corner in rest.split()]
                if len(corners) < 3:
                    raise _wrong(f"a face has {len(corners)} corners; it needs three")
                faces.append((line, corners))
                used.setdefault(current)
                row = "f " + " ".join("/".join(str(i or "") for i in corner) for corner in corners)
            elif word == "mtllib":
                known |= _materials(source.parent / rest.strip())
            elif word == "usemtl":
                current = rest.strip()
                if current not in known:
                    message = f"no material library defines {current!r}"
                    raise AssetError(message, remedy=nearest(current, known))
        rows.append(row)
    if not faces:
        raise AssetError("has no faces", file=source, remedy=_REPAIR)
    for line, corners in faces:
        for kind, index in ((k, i) for c in corners for k, i in zip(_NUMBERS, c, strict=True)):
            if index > counts[kind]:
                with at(source, line):
                    raise _wrong(f"a face names {kind} {index}, but there are {counts[kind]}")
    return "\n".join(rows) + "\n", list(used)


def _check_numbers(word: str, values: list[str]) -> None:
    least, what = _NUMBERS[word]
    if len(values) < least:
        raise _wrong(f"{what} has {len(values)} numbers; it needs {least}")
    for value in values:
        try:
            number = float(value)
        except ValueError:
            raise _wrong(f"{what} holds {value!r}, which is no number") from None
        if not math.isfinite(number):
            raise _wrong(f"{what} holds {value}")


def _corner(text: str, counts: Mapping[str, int]) -> Corner:
    """Position, texture coordinate and normal of a corner as indices from 1; 0 for none."""
    match = _CORNER.fullmatch(text)
    if match is None:
        raise _wrong(f"a face's corner is {text!r}; it must be v, v/vt, v//vn or v/vt/vn")
    found = []
    for kind, index in zip(_NUMBERS, match.groups(), strict=True):
        number = int(index or 0)
        if index is not None and number == 0:
            raise _wrong(f"a face names {kind} 0; the first one is 1")
        absolute = number + counts[kind] + 1 if number < 0 else number
        if number < 0 and absolute < 1:
            raise _wrong(f"a face names {kind} {number}, but there are {counts[kind]} before it")
        found.append(absolute)
    if not found[2]:
        raise AssetError("a face's corner has no normal", remedy="export the model with normals")
    return found[0], found[1], found[2]


def _materials(library: Path) -> dict[str, None]:
    """The names of the materials in a library."""
    if not library.is_file():
        message = f"its material library is not there: {library.name}"
        raise AssetError(message, remedy="put it beside the OBJ file")
    names: dict[str, None] = {}
    for line, row in enumerate(_read_text(library, "a material library").splitlines(), start=1):
        word, *values = row.split("#")[0].split() or [""]
        least = {"Kd": 3, "Ns": 1}.get(word, 0)
        try:
            good = len(values) >= least and all(math.isfinite(float(v)) for v in values[:least])
        except ValueError:
            good = False
        if word == "newmtl":
            names.setdefault(" ".join(values))
        elif not good:
            with at(library, line):
                raise _wrong(f"{word} needs {least} finite numbers")
    return names


def _part(arrays: Mapping[str, Any]) -> Part:
    from trimesh.geometry import triangulate_quads

    material = getattr(arrays["visual"], "material", None)
    said = dict(getattr(material, "kwargs", None) or {})
    uv = getattr(arrays["visual"], "uv", None)
    positions = np.asarray(arrays["vertices"], np.float32)
    normals = np.asarray(arrays["vertex_normals"], float)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    texture = np.zeros((len(positions), 2)) if uv is None else np.asarray(uv)[:, :2]
    color = [float(v) for v in said.get("kd", (0.8, 0.8, 0.8))]
    return Part(
        material=_material(arrays),
        color=(color[0], color[1], color[2]),
        shininess=float(said.get("ns", 0.0)),
        geometry={
            "attributes": {
                "aPos": positions,
                "aNormal": (normals / np.where(lengths > 0.0, lengths, 1.0)).astype(np.float32),
                "aTexCoords": texture.astype(np.float32),
            },
            "indices": triangulate_quads(arrays["faces"]).astype(np.uint32).ravel(),
        },
    )


def _material(arrays: Mapping[str, Any]) -> str:
    material = getattr(arrays.get("visual"), "material", None)
    return str(getattr(material, "name", None) or "")


def _wrong(message: str) -> AssetError:
    return AssetError(message, remedy=_REPAIR)
