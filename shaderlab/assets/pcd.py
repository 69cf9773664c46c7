"""Point clouds from PCD files (Point Cloud Library, version 0.7), through pypcd4.

pypcd4 decodes the three encodings: ascii, binary, and binary_compressed (LZF). It trusts the
header, so the header is checked against the file's size first: nothing is allocated for points that
can't be there.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.assets.obj import at, read_bytes
from shaderlab.errors import AssetError, extra

Array = npt.NDArray[Any]

MAX_BYTES = 256 << 20
"""The largest file that is read, and the largest cloud that is unpacked from one."""

_VERSIONS = ("0.7", ".7")
_LISTS = ("FIELDS", "SIZE", "TYPE", "COUNT")
_COUNTS = ("WIDTH", "HEIGHT", "POINTS")
_ENCODINGS = ("ascii", "binary", "binary_compressed")
_TYPES = {("F", 4), ("F", 8)} | {(sign, size) for sign in "IU" for size in (1, 2, 4, 8)}
_REPAIR = "save the cloud again"


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


@dataclass(frozen=True)
class _Header:
    """What the header says, and where the data begin."""

    fields: tuple[str, ...]
    stride: int
    columns: int
    width: int
    height: int
    encoding: str
    start: int

    @property
    def points(self) -> int:
        return self.width * self.height


def load_pcd(path: str | Path, *, drop_invalid: bool = False) -> Cloud:
    """A point cloud.

    Args:
        path: the file.
        drop_invalid: leave out points with a NaN or infinite coordinate, which sensors write where
            they measured nothing. Otherwise such a point is an error.

    Raises:
        AssetError: the file is missing, is no PCD file, is cut off or shorter than its header says;
            a coordinate is not finite. The message names the file.
    """
    source = Path(path)
    data = read_bytes(source, "a PCD file", MAX_BYTES, "thin the cloud out")
    with at(source):
        header = _header(data)
        _check_size(header, data)
    with extra("models", "a PCD file", source):
        from pypcd4.pypcd4 import PointCloud

    try:
        loaded = PointCloud.from_fileobj(io.BufferedReader(io.BytesIO(data)))
        columns = {name: np.asarray(loaded.pc_data[name]) for name in header.fields}
    except Exception as error:  # pypcd4 passes on its own libraries' errors
        raise AssetError(
            f"can't be decoded ({type(error).__name__}: {error})".splitlines()[0],
            file=source,
            remedy=_REPAIR,
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


def _header(data: bytes) -> _Header:
    """The header's lines, up to and with DATA."""
    said: dict[str, list[str]] = {}
    at = 0
    while "DATA" not in said:
        end = data.find(b"\n", at)
        if end < 0 or end - at > 4096:
            raise _no_pcd("its header has no end" if said else "is no PCD file")
        row = data[at:end].split(b"#")[0].decode("latin-1").split()
        at = end + 1
        if row:
            if not said and row[0] != "VERSION":
                raise _no_pcd(f"is no PCD file: it begins with {row[0][:16]!r}")
            said[row[0]] = row[1:]
    if said["VERSION"][:1] not in ([v] for v in _VERSIONS):
        raise _no_pcd(f"is version {' '.join(said['VERSION'])}; 0.7 is read")
    for word in (*_LISTS[:3], *_COUNTS[:1]):
        if not said.get(word):
            raise _no_pcd(f"its header has no {word}")
    fields = said["FIELDS"]
    counts = _numbers(said.get("COUNT") or ["1"] * len(fields), "COUNT")
    sizes = _numbers(said["SIZE"], "SIZE")
    width = _numbers(said["WIDTH"], "WIDTH")[0]
    height = _numbers(said.get("HEIGHT") or ["1"], "HEIGHT")[0]
    types = list(zip(said["TYPE"], sizes, strict=False))
    if len({len(fields), len(counts), len(sizes), len(said["TYPE"])}) > 1:
        raise _no_pcd("its FIELDS, SIZE, TYPE and COUNT differ in length")
    if not set(types) <= _TYPES or min(counts) < 1:
        raise _no_pcd("its SIZE, TYPE or COUNT is unknown")
    missing = [axis for axis in "xyz" if axis not in fields]
    if missing:
        raise AssetError(f"has no field {' '.join(missing)}", remedy="it needs x, y and z")
    points = _numbers(said.get("POINTS") or [str(width * height)], "POINTS")[0]
    if points != width * height:
        raise _no_pcd(f"promises {points} points, but is {width} × {height}")
    encoding = " ".join(said["DATA"])
    if encoding not in _ENCODINGS:
        raise _no_pcd(f"its DATA is {encoding!r}, not {', '.join(_ENCODINGS)}")
    stride = sum(size * count for size, count in zip(sizes, counts, strict=True))
    return _Header(tuple(fields), stride, sum(counts), width, height, encoding, at)


def _check_size(header: _Header, data: bytes) -> None:
    """The points must be there, and no more than fit into memory."""
    needed, there = header.points * header.stride, len(data) - header.start
    if header.encoding == "ascii":
        rows = [row.split() for row in data[header.start :].splitlines() if row.strip()]
        if len(rows) != header.points:
            raise _cut_off(f"it promises {header.points} points and has {len(rows)}")
        for number, row in enumerate(rows):
            if len(row) != header.columns:
                raise _cut_off(f"point {number} has {len(row)} numbers, not {header.columns}")
        return
    if header.encoding == "binary":
        if there < needed:
            raise _cut_off(f"it promises {header.points} points and has {there // header.stride}")
        return
    if there < 8:
        raise _cut_off("it ends before its data")
    packed, unpacked = struct.unpack_from("<II", data, header.start)
    if unpacked != needed or needed > MAX_BYTES:
        raise _no_pcd(f"promises {header.points} points, {needed} bytes, but unpacks to {unpacked}")
    if there - 8 < packed:
        raise _cut_off(f"it promises {packed} packed bytes and has {there - 8}")


def _numbers(words: list[str], name: str) -> list[int]:
    """Counts in the header.

    >>> _numbers(["4", "4", "1"], "SIZE")
    [4, 4, 1]
    """
    if not all(word.isdecimal() and len(word) < 16 for word in words):
        raise _no_pcd(f"its {name} is {' '.join(words)!r}, which is no count")
    return [int(word) for word in words]


def _no_pcd(message: str) -> AssetError:
    return AssetError(message, remedy=_REPAIR)


def _cut_off(message: str) -> AssetError:
    return AssetError(f"is cut off: {message}", remedy=_REPAIR)
