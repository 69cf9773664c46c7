"""Files are written whole or not at all; paths read well from the working directory."""

from __future__ import annotations

from pathlib import Path

import pytest

from shaderlab.errors import ShaderlabError
from shaderlab.files import display_path, replacing, write_bytes, write_text


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_block_that_fails_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    file.write_text("old")
    with pytest.raises(KeyError), replacing(file) as draft:
        draft.write_text("half")
        raise KeyError
    assert file.read_text() == "old" and names(tmp_path) == ["a.txt"]


def test_a_folder_appears_whole_and_never_over_another(tmp_path: Path) -> None:
    for fails in (False, True):
        try:
            with replacing(tmp_path / "folder") as draft:
                draft.mkdir()
                (draft / str(fails)).write_text("")
        except OSError:
            assert fails
    assert names(tmp_path) == ["folder"] and names(tmp_path / "folder") == ["False"]


def test_a_link_replaces_a_link(tmp_path: Path) -> None:
    for target in ("one", "two"):
        (tmp_path / target).mkdir()
        with replacing(tmp_path / "latest") as draft:
            draft.symlink_to(target)
    assert (tmp_path / "latest").resolve().name == "two"
    assert names(tmp_path) == ["latest", "one", "two"]


def test_text_comes_in_pieces_and_keeps_the_old_file_if_they_end_early(tmp_path: Path) -> None:
    file = tmp_path / "new" / "a.txt"
    write_text(file, ("é\udcff" for _ in range(100)))
    assert file.read_bytes() == ("é?" * 100).encode()

    def pieces():  # type: ignore[no-untyped-def]
        yield "x"
        raise KeyError

    with pytest.raises(KeyError):
        write_text(file, pieces())
    assert file.read_bytes() == ("é?" * 100).encode() and names(file.parent) == ["a.txt"]


def test_what_cannot_be_written_says_where(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ShaderlabError, match="can't write the file") as caught:
        write_text(tmp_path / "file" / "a.txt", "x")
    assert caught.value.file == str(tmp_path / "file" / "a.txt")
    with pytest.raises(OSError):
        write_bytes(tmp_path / "missing" / "a.bin", b"x")


def test_paths_below_the_working_directory_are_relative(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    assert display_path(tmp_path / "a" / "b.frag", 3) == "a/b.frag:3"
    assert display_path("lib/light.glsl") == "lib/light.glsl"
    assert display_path("/x.frag", 1) == "/x.frag:1"
    assert display_path(tmp_path.parent / "other.frag") == str(tmp_path.parent / "other.frag")
