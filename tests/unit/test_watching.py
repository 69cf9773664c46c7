"""The files that a verdict depends on."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from shaderlab.cli.watching import OpenedFiles
from shaderlab.engine.catalogue import find_imported_files


@pytest.fixture
def shader(tmp_path: Path) -> Path:
    file = tmp_path / "shaders" / "lamp.frag"
    file.parent.mkdir()
    file.write_text("a")
    return file


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
    names = {
        path.relative_to(tmp_path).as_posix() for path in find_imported_files(tmp_path / "case.py")
    }
    assert names == {"case.py", "one.py", "two.py", "sub/three.py"}
