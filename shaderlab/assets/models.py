"""Models from files: Wavefront OBJ through trimesh, point clouds in PCD through pypcd4.

trimesh builds the meshes: it merges corners that agree in position, texture coordinate and normal,
splits polygons into triangles and reads the materials. It supports no relative indices and ignores
errors, so every line is checked first, and its indices are made absolute.

pypcd4 decodes the three encodings of the Point Cloud Library's version 0.7: ascii, binary, and
binary_compressed (LZF). It trusts the header, so the header is checked against the file's size
first: nothing is allocated for points that can't be there.
"""

from __future__ import annotations

import io
import math
import re
import struct
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from shaderlab.assets.meshes import Geometry
from shaderlab.errors import AssetError, require_extra, suggest

if TYPE_CHECKING:
    from pypcd4.pypcd4 import MetaData

Array = npt.NDArray[Any]

OBJ_MAX_BYTES = 64 << 20
"""The largest file that is read."""

_NUMBERS = {"v": (3, "a position"), "vt": (2, "a texture coordinate"), "vn": (3, "a normal")}
_CORNER = re.compile(r"(-?\d+)(?:/(-?\d+)?(?:/(-?\d+))?)?")
_EXPORT = "export the model again"
_SPELLING = "check the path and its spelling"

Corner = tuple[int, int, int]

PCD_MAX_BYTES = 256 << 20
"""The largest file that is read, and the largest cloud that is unpacked from one."""

_SAVE = "save the cloud again"


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
    smoothing are read over. Raises AssetError: the file or its material library is missing or can't
    be read, a line is cut off or malformed, a number is not finite, an index leads nowhere, or
    there are no faces; the message names the file and the line."""
    source = Path(path)
    text, names = _check_text(source)
    with require_extra("models", "an OBJ file", source):
        import trimesh

    resolver = trimesh.resolvers.FilePathResolver(str(source.resolve()))
    try:
        made = trimesh.exchange.obj.load_obj(io.StringIO(text), resolver=resolver)
    except Exception as error:  # its parser raises many kinds
        raise AssetError(
            f"trimesh can't read it ({type(error).__name__}: {error})", file=source, remedy=_EXPORT
        ) from error
    found = made.get("geometry") or {names[0] if names else "": made}
    parts = {_material_name(arrays): _make_part(arrays) for arrays in found.values()}
    return tuple(parts[name] for name in names if name in parts)


def read_bytes(source: Path, what: str, limit: int, too_large: str) -> bytes:
    """Read a model's file: `what` names its kind, `too_large` the remedy above `limit` bytes.
    Raises AssetError: it is missing, a folder, unreadable or too large."""
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
        text = read_bytes(source, what, OBJ_MAX_BYTES, "simplify the model").decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise AssetError(
            f"is no text: byte {error.start} is 0x{error.object[error.start]:02x}",
            file=source,
            remedy=f"see whether this is {what} at all",
        ) from None
    if not text.strip():
        raise AssetError("the file is empty", file=source, remedy=_EXPORT)
    return text


@contextmanager
def _add_place(source: Path, line: int | None = None) -> Iterator[None]:
    try:
        yield
    except AssetError as error:
        if error.file is not None:
            raise
        raise AssetError(error.message, file=source, line=line, remedy=error.remedy) from None


def _check_text(source: Path) -> tuple[str, list[str]]:
    """The text with absolute indices, and the materials in the order of their first use."""
    rows: list[str] = []
    counts = dict.fromkeys(_NUMBERS, 0)
    faces: list[tuple[int, list[Corner]]] = []
    known: dict[str, None] = {}
    used: dict[str, None] = {}
    current = ""
    for line, row in enumerate(_read_text(source, "an OBJ file").splitlines(), start=1):
        word, _, rest = row.split("#")[0].strip().partition(" ")
        with _add_place(source, line):
            if word in _NUMBERS:
                _check_numbers(word, rest.split())
                counts[word] += 1
            elif word == "f":
                corners = [_parse_corner(corner, counts) for corner in rest.split()]
                if len(corners) < 3:
                    raise _obj_error(f"a face has {len(corners)} corners; it needs three")
                faces.append((line, corners))
                used.setdefault(current)
                row = "f " + " ".join("/".join(str(i or "") for i in corner) for corner in corners)
            elif word == "mtllib":
                known |= _read_materials(source.parent / rest.strip())
            elif word == "usemtl":
                current = rest.strip()
                if current not in known:
                    message = f"no material library defines {current!r}"
                    raise AssetError(message, remedy=suggest(current, known))
        rows.append(row)
    if not faces:
        raise AssetError("has no faces", file=source, remedy=_EXPORT)
    for line, corners in faces:
        for kind, index in ((k, i) for c in corners for k, i in zip(_NUMBERS, c, strict=True)):
            if index > counts[kind]:
                with _add_place(source, line):
                    raise _obj_error(f"a face names {kind} {index}, but there are {counts[kind]}")
    return "\n".join(rows) + "\n", list(used)


def _check_numbers(word: str, values: list[str]) -> None:
    least, what = _NUMBERS[word]
    if len(values) < least:
        raise _obj_error(f"{what} has {len(values)} numbers; it needs {least}")
    for value in values:
        try:
            number = float(value)
        except ValueError:
            raise _obj_error(f"{what} holds {value!r}, which is no number") from None
        if not math.isfinite(number):
            raise _obj_error(f"{what} holds {value}")


def _parse_corner(text: str, counts: Mapping[str, int]) -> Corner:
    """Position, texture coordinate and normal of a corner as indices from 1; 0 for none.

    >>> _parse_corner("-1//2", {"v": 3, "vt": 0, "vn": 2})
    (3, 0, 2)
    """
    match = _CORNER.fullmatch(text)
    if match is None:
        raise _obj_error(f"a face's corner is {text!r}; it must be v, v/vt, v//vn or v/vt/vn")
    found = []
    for kind, index in zip(_NUMBERS, match.groups(), strict=True):
        number = int(index or 0)
        if index is not None and number == 0:
            raise _obj_error(f"a face names {kind} 0; the first one is 1")
        absolute = number + counts[kind] + 1 if number < 0 else number
        if number < 0 and absolute < 1:
            raise _obj_error(
                f"a face names {kind} {number}, but there are {counts[kind]} before it"
            )
        found.append(absolute)
    if not found[2]:
        raise AssetError("a face's corner has no normal", remedy="export the model with normals")
    return found[0], found[1], found[2]


def _read_materials(library: Path) -> dict[str, None]:
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
            with _add_place(library, line):
                raise _obj_error(f"{word} needs {least} finite numbers")
    return names


def _make_part(arrays: Mapping[str, Any]) -> Part:
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
        material=_material_name(arrays),
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


def _material_name(arrays: Mapping[str, Any]) -> str:
    material = getattr(arrays.get("visual"), "material", None)
    return str(getattr(material, "name", None) or "")


def _obj_error(message: str) -> AssetError:
    return AssetError(message, remedy=_EXPORT)


@dataclass(frozen=True, kw_only=True)
class Cloud:
    """Points, with their other fields.

    Attributes:
        positions: (n, 3) float32, from the fields x, y and z.
        fields: every other field by name, (n,) or (n, count), in the file's own type.
        width, height: as in the file: an organised cloud has rows, another height 1.
    """

    positions: Array
    fields: Mapping[str, Array]
    width: int
    height: int


def load_pcd(path: str | Path, *, drop_invalid: bool = False) -> Cloud:
    """A point cloud.

    Args:
        path: the file.
        drop_invalid: leave out points with a NaN or infinite coordinate, which sensors write where
            they measured nothing. Otherwise such a point is an error.

    Raises AssetError: the file is missing, is no PCD file, is cut off or shorter than its header
    says; a coordinate is not finite. The message names the file."""
    source = Path(path)
    data = read_bytes(source, "a PCD file", PCD_MAX_BYTES, "thin the cloud out")
    with require_extra("models", "a PCD file", source):
        from pypcd4.pypcd4 import PointCloud
    with _add_place(source):
        header, start = _parse_header(data)
        _check_size(header, data[start:])
    try:
        loaded = PointCloud.from_fileobj(io.BufferedReader(io.BytesIO(data)))
        columns = {name: np.asarray(loaded.pc_data[name]) for name in header.fields}
    except Exception as error:  # pypcd4 passes on its own libraries' errors
        raise AssetError(
            f"can't be decoded ({type(error).__name__}: {error})".splitlines()[0],
            file=source,
            remedy=_SAVE,
        ) from error
    positions = np.stack([columns.pop(axis) for axis in "xyz"], axis=-1).astype(np.float32)
    finite = np.isfinite(positions).all(axis=1)
    if not drop_invalid and not finite.all():
        first = int(np.argmin(finite))
        raise AssetError(
            f"point {first} is {positions[first].tolist()}",
            file=source,
            remedy="leave such points out with drop_invalid=True",
        )
    return Cloud(
        positions=np.ascontiguousarray(positions[finite]),
        fields={name: values[finite] for name, values in columns.items()},
        width=header.width if finite.all() else int(finite.sum()),
        height=header.height if finite.all() else 1,
    )


def _parse_header(data: bytes) -> tuple[MetaData, int]:
    """The header, and where the points begin."""
    from pypcd4.pypcd4 import PCD_TYPE_TO_NUMPY_TYPE, MetaData

    rows: list[str] = []
    at = 0
    while not rows or not rows[-1].startswith("DATA"):
        end = data.find(b"\n", at)
        if end < 0 or end - at > 4096:
            raise _pcd_error("its header has no end" if rows else "is no PCD file")
        row = data[at:end].decode("latin-1").strip()
        at = end + 1
        if row and not row.startswith("#"):
            rows.append(row)
            if not rows[0].startswith("VERSION"):
                raise _pcd_error(f"is no PCD file: it begins with {row[:16]!r}")
    try:
        header = MetaData.parse_header(rows)
    except ValueError as error:  # what pydantic says of the first field, or what Python says
        said = " ".join(map(str.strip, str(error).splitlines()[1:3] or [str(error)]))
        raise _pcd_error(f"its header can't be read: {said}") from None
    if len({len(header.fields), len(header.size), len(header.type), len(header.count)}) > 1:
        raise _pcd_error("its FIELDS, SIZE, TYPE and COUNT differ in length")
    if not PCD_TYPE_TO_NUMPY_TYPE.keys() >= set(zip(header.type, header.size, strict=True)):
        raise _pcd_error("its SIZE or TYPE is unknown")
    missing = [axis for axis in "xyz" if axis not in header.fields]
    if missing:
        raise AssetError(f"has no field {' '.join(missing)}", remedy="it needs x, y and z")
    if header.points != header.width * header.height:
        size = f"{header.width} × {header.height}"
        raise _pcd_error(f"promises {header.points} points, but is {size}")
    return header, at


def _check_size(header: MetaData, data: bytes) -> None:
    """The points must be there, and no more than fit into memory."""
    points, there, kind = header.points, len(data), header.build_dtype()
    needed = points * kind.itemsize
    if header.data == "ascii":
        rows = [row.split() for row in data.splitlines() if row.strip()]
        if len(rows) != points:
            raise _cut_error(f"it promises {points} points and has {len(rows)}")
        for number, row in enumerate(rows):
            if len(row) != sum(header.count):
                raise _cut_error(f"point {number} has {len(row)} numbers, not {sum(header.count)}")
        return
    if header.data == "binary":
        if there < needed:
            raise _cut_error(f"it promises {points} points and has {there // kind.itemsize}")
        return
    if there < 8:
        raise _cut_error("it ends before its data")
    packed, unpacked = struct.unpack_from("<II", data)
    if unpacked != needed or needed > PCD_MAX_BYTES:
        raise _pcd_error(f"promises {points} points, {needed} bytes, but unpacks to {unpacked}")
    if there - 8 < packed:
        raise _cut_error(f"it promises {packed} packed bytes and has {there - 8}")


def _pcd_error(message: str) -> AssetError:
    return AssetError(message, remedy=_SAVE)


def _cut_error(message: str) -> AssetError:
    return AssetError(f"is cut off: {message}", remedy=_SAVE)
