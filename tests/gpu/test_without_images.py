"""Without the extra "images": whole runs with pictures and pages, and a clear word where a case
reads an image file. OpenImageIO can't be imported here, and everything happens in this process.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.model import pictures
from tests.small_case import example

__all__ = ["example"]

TEXTURED = """\
from shaderlab import Case, Texture, exact, fullscreen

case = Case(
    title="A picture from disk",
    passes=fullscreen("t.frag", textures={"image": Texture(image="red.png", format="rgb8")}),
    expect=[exact("FragColor", (1.0, 0.0, 0.0, 1.0))],
)
"""
SHADER = """\
#version 330 core
uniform sampler2D image;
out vec4 FragColor;
void main() { FragColor = texelFetch(image, ivec2(0), 0); }
"""


@pytest.fixture
def folder(example: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A small case, and no OpenImageIO."""
    (example / "t.frag").write_text(SHADER)
    (example / "t.py").write_text(TEXTURED)
    pictures.save_png(example / "red.png", np.full((4, 4, 3), (255, 0, 0), np.uint8))
    monkeypatch.chdir(example)
    monkeypatch.setenv("SHADERLAB_JOBS", "0")
    monkeypatch.setitem(sys.modules, "OpenImageIO", None)
    return example


def shaderlab(*words: str) -> tuple[int, str]:
    done = CliRunner().invoke(cli, words, catch_exceptions=False)
    return done.exit_code, done.output


def test_a_case_is_drawn_judged_and_shown(folder: Path) -> None:
    for words in (
        ("run", "lambert.py", "--size", "330", "--report", "out", "--json", "o.json"),
        ("report", "out", "--single-file", "out/all.html"),
    ):
        code, said = shaderlab(*words)
        assert code == 0, said
    drawn = {path.name.partition("--default--")[2] for path in (folder / "out/images").iterdir()}
    assert "picture.png" in drawn
    site, single = (
        (folder / "out" / file).read_text("utf-8") for file in ("index.html", "all.html")
    )
    assert '<img src="images/lambert--default--small' in site
    assert 'src="data:image/png;base64,iVBOR' in single


def test_pytest_runs_it(folder: Path, pytester: pytest.Pytester) -> None:
    words = ("-p", "no:xdist", f"--shaderlab-report={folder / 'out'}", str(folder / "lambert.py"))
    pytester.runpytest_inprocess(*words).assert_outcomes(passed=1)
    assert list((folder / "out/images").glob("*--picture.png"))


def test_an_image_file_asks_for_the_extra(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code, said = shaderlab("run", "t.py", "--report", "out")
    assert code == 1
    assert "red.png: reading an image file needs OpenImageIO" in said
    assert "→ pip install 'shaderlab[images]'" in said
    monkeypatch.delitem(sys.modules, "OpenImageIO")  # as where the extra is installed
    code, said = shaderlab("run", "t.py", "--report", "out")
    assert code == 0, said
