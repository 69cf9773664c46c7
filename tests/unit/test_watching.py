"""Saved files: what editors do to them, and what was changed."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from shaderlab.cli.watching import Changes, Contents, OpenedFiles
from shaderlab.engine.catalogue import imported_files


@pytest.fixture
def shader(tmp_path: Path) -> Path:
    file = tmp_path / "shaders" / "lamp.frag"
    file.parent.mkdir()
    file.write_text("a")
    return file


@pytest.fixture
def changes(shader: Path) -> Iterator[Changes]:
    with Changes([shader.parent]) as changes:
        wait_until_watched(changes, shader.parent)
        yield changes


def wait_until_watched(changes: Changes, folder: Path) -> None:
    """Write to a file until the system's watch reports it: it begins with its thread's first
    step."""
    probe = folder / "probe"
    for number in range(600):
        probe.write_text(f"{number}")
        if probe in changes.next(0.1):
            break
    while changes.next(0.3):
        pass


def until(changes: Changes, file: Path, known: set[Path]) -> set[Path]:
    """What `changes` gives, up to the moment that has the file."""
    found: set[Path] = set()
    for _ in range(120):
        found |= changes.settled(changes.next(0.5), known)
        if file in found:
            return found
    raise AssertionError(f"{file} is not among {found}")


def test_a_save_is_one_moment_however_it_is_done(changes: Changes, shader: Path) -> None:
    contents = Contents()
    contents.learn([shader])
    draft = shader.with_name("lamp.frag~")

    def saved() -> None:
        found = until(changes, shader, {shader})
        assert contents.changed(found) >= {shader}
        # A busy machine may report one save in two moments: the second one changes nothing.
        assert not contents.changed(changes.next(0.1) & {shader})

    shader.write_text("b")
    saved()
    draft.write_text("c")
    draft.replace(shader)
    saved()
    for text in "def":
        shader.write_text(text)
    saved()
    shader.unlink()
    shader.write_text("g")
    saved()
    assert shader.read_text() == "g"


def test_a_file_that_is_removed_for_a_moment_is_waited_for(changes: Changes, shader: Path) -> None:
    shader.unlink()
    found = changes.next(2.0)
    while shader not in found:
        found |= changes.next(2.0)
    shader.write_text("b")
    assert shader in changes.settled(found, {shader})
    shader.unlink()
    assert shader in until(changes, shader, {shader})  # it stays away, which is a change as well


def test_further_folders_are_watched_once(changes: Changes, shader: Path) -> None:
    other = shader.parents[1] / "textures"
    (shader.parent / "lib").mkdir()
    other.mkdir()
    changes.add([other, shader.parent / "lib", shader.parent, other / "missing"])
    assert len(changes._threads) == 2
    wait_until_watched(changes, other)
    (other / "a.png").write_bytes(b"x")
    assert until(changes, other / "a.png", set())


def test_what_was_only_touched_has_not_changed(shader: Path, tmp_path: Path) -> None:
    contents, missing = Contents(), tmp_path / "missing"
    contents.learn([shader, missing])
    os.utime(shader)
    assert contents.changed([shader, missing]) == set()
    shader.write_text("b")
    contents.learn([shader])
    assert contents.changed([shader]) == {shader}
    assert contents.changed([shader]) == set()
    shader.unlink()
    missing.write_text("")
    assert contents.changed([shader, missing]) == {shader, missing}


def test_what_is_written_while_it_is_judged_has_changed(shader: Path) -> None:
    contents, began = Contents(), time.time()
    shader.write_text("b")
    contents.learn([shader], began)
    assert contents.changed([shader]) == {shader}
    os.utime(shader, (began - 60.0, began - 60.0))
    contents = Contents()
    contents.learn([shader], began)
    assert contents.changed([shader]) == set()


def test_files_that_are_read_are_noted_missing_ones_too(shader: Path) -> None:
    opened = OpenedFiles()
    with opened.noted() as files:
        shader.read_text()
        with pytest.raises(FileNotFoundError):
            (shader.parent / "gone.glsl").read_bytes()
        shader.with_name("written.txt").write_text("x")
        Path(pytest.__file__).read_bytes()
        Path(sys.modules[OpenedFiles.__module__].__file__ or "").read_bytes()
    assert files == {shader, shader.parent / "gone.glsl"}
    shader.read_text()
    with opened.noted() as files:
        pass
    assert files == set()


def test_modules_of_a_project_are_followed(tmp_path: Path) -> None:
    (tmp_path / "case.py").write_text("import math\nfrom one import x\nfrom .sub import three\n")
    (tmp_path / "one.py").write_text("import two, case\n")
    (tmp_path / "two.py").write_text("def broken(:\n")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "three.py").write_text("")
    names = {path.relative_to(tmp_path).as_posix() for path in imported_files(tmp_path / "case.py")}
    assert names == {"case.py", "one.py", "two.py", "sub/three.py"}
