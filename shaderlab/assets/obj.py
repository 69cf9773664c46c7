"""Wavefront OBJ files, through trimesh.

trimesh builds the meshes: it merges corners that agree in position, texture coordinate and normal,
splits polygons into triangles and reads the materials. It supports no relative indices and ignores
errors, so every line is checked first, and its indices are made absolute.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping
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
    with extra("models", "an OBJ file"):
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


def read_text(source: Path, what: str) -> str:
    """A text file of a mesh.

    Raises:
        AssetError: it is missing, a folder, unreadable, too large, empty, or not UTF-8.
    """
    if not source.is_file():
        found = (
            f"is a folder, not {what}"
            if source.is_dir()
            else f"there is no such file ({what} was asked for)"
        )
        raise AssetError(found, file=source, remedy="check the path and its spelling")
    try:
        if source.stat().st_size > MAX_BYTES:
            raise AssetError(
                f"is larger than {MAX_BYTES >> 20} MiB", file=source, remedy="simplify the model"
            )
        text = source.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise AssetError(f"can't be read: {error.strerror or error}", file=source) from error
    except UnicodeDecodeError as error:
        raise AssetError(
            f"is no text: byte {error.start} is 0x{error.object[error.start]:02x}",
            file=source,
            remedy=f"see whether this is {what} at all",
        ) from None
    if not text.strip():
        raise AssetError("the file is empty", file=source, remedy=_REPAIR)
    return text


def _checked(source: Path) -> tuple[str, list[str]]:
    """The text with absolute indices, and the materials in the order of their first use."""
    rows: list[str] = []
    counts = dict.fromkeys(_NUMBERS, 0)
    faces: list[tuple[int, list[tuple[int, int, int]]]] = []
    known: dict[str, int] = {}
    used: dict[str, None] = {}
    current = ""
    for line, row in enumerate(read_text(source, "an OBJ file").splitlines(), start=1):
        word, _, rest = row.split("#")[0].strip().partition(" ")
        if word in _NUMBERS:
            _check_numbers(word, rest.split(), source, line)
            counts[word] += 1
        elif word == "f":
            corners = [_corner(corner, counts, source, line) for corner in rest.split()]
            if len(corners) < 3:
                raise _wrong(f"a face has {len(corners)} corners; it needs three", source, line)
            faces.append((line, corners))
            used.setdefault(current)
            row = "f " + " ".join(_spelt(corner) for corner in corners)
        elif word == "mtllib":
            known |= _materials(source.parent / rest.strip(), source, line)
        elif word == "usemtl":
            current = rest.strip()
            if current not in known:
                raise AssetError(
                    f"no material library defines {current!r}",
                    file=source,
                    line=line,
                    remedy=nearest(current, known),
                )
        rows.append(row)
    if not faces:
        raise AssetError("has no faces", file=source, remedy=_REPAIR)
    _check_indices(faces, counts, source)
    return "\n".join(rows) + "\n", list(used)


def _check_numbers(word: str, values: list[str], source: Path, line: int) -> None:
    least, what = _NUMBERS[word]
    if len(values) < least:
        raise _wrong(f"{what} has {len(values)} numbers; it needs {least}", source, line)
    for value in values:
        try:
            number = float(value)
        except ValueError:
            raise _wrong(f"{what} holds {value!r}, which is no number", source, line) from None
        if not math.isfinite(number):
            raise _wrong(f"{what} holds {value}", source, line)


def _corner(text: str, counts: Mapping[str, int], source: Path, line: int) -> tuple[int, int, int]:
    """Position, texture coordinate and normal of a corner as indices from 1; 0 for none."""
    match = _CORNER.fullmatch(text)
    if match is None:
        raise _wrong(f"a face's corner is {text!r}; it must be v, v/vt, v//vn or v/vt/vn", source,
                     line)  # fmt: skip
    found = []
    for kind, index in zip(_NUMBERS, match.groups(), strict=True):
        number = 0 if index is None else int(index)
        if index is not None and number == 0:
            raise _wrong(f"a face names {kind} 0; the first one is 1", source, line)
        absolute = number + counts[kind] + 1 if number < 0 else number
        if number < 0 and absolute < 1:
            raise _wrong(
                f"a face names {kind} {number}, but there are {counts[kind]} before it",
                source,
                line,
            )
        found.append(absolute)
    if not found[2]:
        raise AssetError(
            "a face's corner has no normal",
            file=source,
            line=line,
            remedy="export the model with normals",
        )
    return found[0], found[1], found[2]


def _check_indices(
    faces: list[tuple[int, list[tuple[int, int, int]]]], counts: Mapping[str, int], source: Path
) -> None:
    for line, corners in faces:
        for corner in corners:
            for kind, index in zip(_NUMBERS, corner, strict=True):
                if index > counts[kind]:
                    raise _wrong(
                        f"a face names {kind} {index}, but there are {counts[kind]}", source, line
                    )


def _materials(library: Path, source: Path, line: int) -> dict[str, int]:
    """The materials' names with the lines that define them."""
    if not library.is_file():
        raise AssetError(
            f"its material library is not there: {library.name}",
            file=source,
            line=line,
            remedy="put it beside the OBJ file",
        )
    names = {}
    for number, row in enumerate(read_text(library, "a material library").splitlines(), start=1):
        words = row.split("#")[0].split()
        if words[:1] == ["newmtl"]:
            names[" ".join(words[1:])] = number
        elif words[:1] in (["Kd"], ["Ns"]):
            _check_numbers_of(words, library, number)
    return names


def _check_numbers_of(words: list[str], library: Path, line: int) -> None:
    least = {"Kd": 3, "Ns": 1}[words[0]]
    try:
        good = len(words) > least and all(math.isfinite(float(w)) for w in words[1 : least + 1])
    except ValueError:
        good = False
    if not good:
        raise _wrong(f"{words[0]} needs {least} finite numbers", library, line)


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


def _spelt(corner: tuple[int, int, int]) -> str:
    """A corner as OBJ writes it.

    >>> _spelt((4, 0, 2))
    '4//2'
    """
    return "/".join(str(index) if index else "" for index in corner)


def _wrong(message: str, source: Path, line: int) -> AssetError:
    return AssetError(message, file=source, line=line, remedy=_REPAIR)
