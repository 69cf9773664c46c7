"""OBJ files: what is read, and every way in which one can be broken."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from shaderlab.assets import load_obj
from shaderlab.errors import AssetError

OBJ = """\
mtllib house.mtl
o house
v -1 0 0
v 1 0 0
v 1 1 0
v -1 1 0
v 0 2 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 2
usemtl wall
f 1/1/1 2/2/1 3/3/1 4/4/1
usemtl roof
f -2//-1 -3//-1 -1//-1
"""
MTL = "newmtl roof\nKd 0.75 0.25 0.125\nnewmtl wall\nKd 0.5 0.5 0.5\nNs 32\n"


def written(folder: Path, text: str = OBJ, library: str | None = MTL) -> Path:
    path = folder / "house.obj"
    path.write_text(text)
    if library is not None:
        (folder / "house.mtl").write_text(library)
    return path


def test_faces_come_by_material_in_the_order_of_use(tmp_path: Path) -> None:
    wall, roof = load_obj(written(tmp_path))
    assert (wall.material, wall.color, wall.shininess) == ("wall", (0.5, 0.5, 0.5), 32.0)
    assert (roof.material, roof.color, roof.shininess) == ("roof", (0.75, 0.25, 0.125), 0.0)
    assert [len(p.geometry["indices"]) for p in (wall, roof)] == [6, 3]  # a quad, a triangle


def test_relative_indices_count_back_from_where_they_stand(tmp_path: Path) -> None:
    _, roof = load_obj(written(tmp_path))
    corners = roof.geometry["attributes"]["aPos"][roof.geometry["indices"]]
    assert corners.tolist() == [[-1, 1, 0], [1, 1, 0], [0, 2, 0]]


def test_arrays_are_what_a_mesh_takes(tmp_path: Path) -> None:
    wall, roof = load_obj(written(tmp_path))
    attributes = wall.geometry["attributes"]
    assert {n: (v.shape, v.dtype) for n, v in attributes.items()} == {
        "aPos": ((4, 3), np.float32),
        "aNormal": ((4, 3), np.float32),
        "aTexCoords": ((4, 2), np.float32),
    }
    assert (attributes["aNormal"] == (0, 0, 1)).all()  # made unit length
    place = dict(zip(map(tuple, attributes["aPos"].tolist()), attributes["aTexCoords"].tolist(),
                     strict=True))  # fmt: skip
    assert place == {(-1, 0, 0): [0, 0], (1, 0, 0): [1, 0], (1, 1, 0): [1, 1], (-1, 1, 0): [0, 1]}
    assert (roof.geometry["attributes"]["aTexCoords"] == 0).all()
    assert wall.geometry["indices"].dtype == np.uint32


def test_carriage_returns_a_mark_and_comments_are_read_over(tmp_path: Path) -> None:
    path = written(tmp_path)
    path.write_bytes(b"\xef\xbb\xbf# a house\r\n" + OBJ.replace("\n", "\r\n").encode())
    assert [part.material for part in load_obj(path)] == ["wall", "roof"]


def test_a_file_without_materials_is_one_part(tmp_path: Path) -> None:
    bare = "\n".join(row for row in OBJ.splitlines() if "mtl" not in row)
    (part,) = load_obj(written(tmp_path, bare, None))
    assert (part.material, len(part.geometry["indices"])) == ("", 9)


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("v 0 2 0", "v 0 2", 7, "a position has 2 numbers; it needs 3"),
        ("v 0 2 0", "v nan 2 0", 7, "a position holds nan"),
        ("v 0 2 0", "v 0 inf 0", 7, "a position holds inf"),
        ("v 0 2 0", "v 0 two 0", 7, "a position holds 'two', which is no number"),
        ("f -2//-1 -3//-1 -1//-1", "f 1//1 2//1", 16, "a face has 2 corners; it needs three"),
        ("-1//-1", "9//-1", 16, "a face names v 9, but there are 5"),
        ("4/4/1", "4/7/1", 14, "a face names vt 7, but there are 4"),
        ("-1//-1", "-6//-1", 16, "a face names v -6, but there are 5 before it"),
        ("-1//-1", "0//-1", 16, "a face names v 0; the first one is 1"),
        ("-1//-1", "x//-1", 16, "a face's corner is 'x//-1'; it must be v, v/vt, v//vn or "
         "v/vt/vn"),
        ("-1//-1", "-1", 16, "a face's corner has no normal"),
        ("usemtl roof", "usemtl rood", 15, "no material library defines 'rood'"),
        ("house.mtl", "home.mtl", 1, "its material library is not there: home.mtl"),
    ],
)  # fmt: skip
def test_a_broken_line_is_named(
    tmp_path: Path, old: str, new: str, line: int, message: str
) -> None:
    path = written(tmp_path, OBJ.replace(old, new))
    with pytest.raises(AssetError) as caught:
        load_obj(path)
    assert (caught.value.file, caught.value.line) == (str(path), line)
    assert caught.value.message == message
    assert caught.value.remedy


@pytest.mark.parametrize("bad", ["Kd 0.5 0.5", "Kd 0.5 0.5 nan", "Ns much"])
def test_a_broken_material_is_named(tmp_path: Path, bad: str) -> None:
    path = written(tmp_path, library=MTL + bad + "\n")
    with pytest.raises(AssetError, match=rf"house\.mtl:6: {bad[:2]} needs"):
        load_obj(path)


@pytest.mark.parametrize("size", range(0, len(OBJ), 7))
def test_a_file_cut_anywhere_is_read_or_refused_by_name(tmp_path: Path, size: int) -> None:
    path = written(tmp_path, OBJ[:size])
    try:
        parts = load_obj(path)
    except AssetError as error:
        assert error.file == str(path)
    else:
        assert sum(len(p.geometry["indices"]) for p in parts) in (6, 9)


def test_what_is_no_obj_file_at_all(tmp_path: Path) -> None:
    (tmp_path / "noise.obj").write_bytes(bytes(range(128, 256)))
    (tmp_path / "words.obj").write_text("no faces here\n")
    (tmp_path / "empty.obj").write_text("")
    for name, message in (
        ("noise.obj", "is no text: byte 0 is 0x80"),
        ("words.obj", "has no faces"),
        ("empty.obj", "the file is empty"),
        ("absent.obj", r"there is no such file \(an OBJ file was asked for\)"),
        ("", "is a folder, not an OBJ file"),
    ):
        with pytest.raises(AssetError, match=message):
            load_obj(tmp_path / name)
