"""PCD files: the three encodings, and headers that promise what is not there."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from shaderlab.assets import load_pcd
from shaderlab.errors import AssetError

COUNT = 20
POINTS = np.random.default_rng(5).normal(size=(COUNT, 3)).astype(np.float32)
LEVEL = np.arange(COUNT, dtype=np.uint8)


def header(encoding: str, **changes: object) -> bytes:
    said = {
        "VERSION": "0.7", "FIELDS": "x y z level", "SIZE": "4 4 4 1", "TYPE": "F F F U",
        "COUNT": "1 1 1 1", "WIDTH": COUNT, "HEIGHT": 1, "VIEWPOINT": "0 0 0 1 0 0 0",
        "POINTS": COUNT, "DATA": encoding,
    }  # fmt: skip
    said |= changes
    return "".join(f"{word} {value}\n" for word, value in said.items() if value != "").encode()


def body(encoding: str, points: np.ndarray = POINTS) -> bytes:
    if encoding == "ascii":
        rows = (" ".join(map(repr, p.tolist())) for p in points)
        return "".join(f"{row} {level}\n" for row, level in zip(rows, LEVEL, strict=True)).encode()
    if encoding == "binary":
        return b"".join(p.tobytes() + bytes([n]) for p, n in zip(points, LEVEL, strict=True))
    import lzf

    plain = points.T.tobytes() + LEVEL.tobytes()
    packed = lzf.compress(plain + b"", 2 * len(plain))
    return struct.pack("<II", len(packed), len(plain)) + packed


def written(folder: Path, data: bytes) -> Path:
    path = folder / "cloud.pcd"
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
def test_every_encoding_gives_the_same_points(tmp_path: Path, encoding: str) -> None:
    cloud = load_pcd(written(tmp_path, b"# .PCD v0.7\n" + header(encoding) + body(encoding)))
    assert (cloud.positions == POINTS).all() and cloud.positions.dtype == np.float32
    assert (cloud.fields["level"] == LEVEL).all() and list(cloud.fields) == ["level"]
    assert (cloud.width, cloud.height) == (COUNT, 1)


@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
def test_a_file_cut_anywhere_is_refused_by_name(tmp_path: Path, encoding: str) -> None:
    whole = header(encoding) + body(encoding)
    for size in range(0, len(whole) - 3, 11):
        path = written(tmp_path, whole[:size])
        with pytest.raises(AssetError) as caught:
            load_pcd(path)
        assert caught.value.file == str(path) and caught.value.remedy


@pytest.mark.parametrize(
    ("encoding", "changes", "message"),
    [
        ("ascii", {"WIDTH": 10**12, "POINTS": 10**12}, "is cut off: it promises 1000000000000"),
        ("binary", {"WIDTH": 10**12, "POINTS": 10**12}, "is cut off: it promises 1000000000000"),
        ("binary_compressed", {"WIDTH": 10**9, "POINTS": 10**9}, "promises 1000000000 points"),
        ("binary", {"POINTS": COUNT + 1}, "promises 21 points, but is 20 × 1"),
        ("binary", {"WIDTH": "many"}, "its header can't be read"),
        ("binary", {"WIDTH": "-4"}, "its header can't be read: width Input should be"),
        ("binary", {"VERSION": "0.6"}, "its header can't be read: version Input should be"),
        ("binary", {"FIELDS": "a b c level"}, "has no field x y z"),
        ("binary", {"SIZE": "4 4 4"}, "its FIELDS, SIZE, TYPE and COUNT differ in length"),
        ("binary", {"TYPE": "F F F F"}, "its SIZE or TYPE is unknown"),
        ("binary", {"COUNT": "1 1 1 0"}, "its header can't be read: count.3 Input should be"),
        ("binary", {"FIELDS": ""}, "its header can't be read: fields Field required"),
        (
            "binary",
            {"DATA": "zip"},
            "its header can't be read: data Input should be 'ascii', 'binary'",
        ),
    ],
)
def test_a_header_is_not_believed(
    tmp_path: Path, encoding: str, changes: dict[str, object], message: str
) -> None:
    path = written(tmp_path, header(encoding, **changes) + body(encoding))
    with pytest.raises(AssetError) as caught:
        load_pcd(path)
    assert caught.value.message.startswith(message)


def test_what_is_no_pcd_file(tmp_path: Path) -> None:
    for data, message in (
        (b"", "is no PCD file"),
        (b"\x89PNG\r\n\x1a\n" + bytes(64), "is no PCD file: it begins with"),
        (header("binary").replace(b"VERSION", b"VERSOIN"), "is no PCD file: it begins with"),
        (b"VERSION 0.7\n" + b"x" * 9000, "its header has no end"),
    ):
        with pytest.raises(AssetError, match=message):
            load_pcd(written(tmp_path, data))
    for name, message in (("absent.pcd", r"\(a PCD file was asked for\)"), ("", "is a folder")):
        with pytest.raises(AssetError, match=message):
            load_pcd(tmp_path / name)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_point_that_was_not_measured(tmp_path: Path, bad: float) -> None:
    points = POINTS.copy()
    points[7, 1] = bad
    path = written(tmp_path, header("binary") + body("binary", points))
    with pytest.raises(AssetError, match="point 7 is") as caught:
        load_pcd(path)
    assert caught.value.remedy == "leave such points out with drop_invalid=True"
    cloud = load_pcd(path, drop_invalid=True)
    assert len(cloud.positions) == COUNT - 1
    assert (cloud.fields["level"] == np.delete(LEVEL, 7)).all()
    assert (cloud.width, cloud.height) == (COUNT - 1, 1)


@pytest.mark.parametrize("encoding", ["binary", "binary_compressed"])
def test_noise_after_a_good_header_is_read_or_refused(tmp_path: Path, encoding: str) -> None:
    noise = np.random.default_rng(1)
    for _ in range(40):
        data = bytearray(header(encoding) + body(encoding))
        for place in noise.integers(0, len(data), 4):
            data[place] = noise.integers(256)
        try:
            cloud = load_pcd(written(tmp_path, bytes(data)), drop_invalid=True)
        except AssetError as error:
            assert error.file
        else:
            assert len(cloud.positions) <= COUNT
