"""What a shader of GLSL ES leaves to 16 bits is named, and nothing of another."""

from __future__ import annotations

from pathlib import Path

import pytest

from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import find_below_highp

HIGH = "precision highp float;\nuniform sampler2D scene;\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("#version 300 es\n" + HIGH, "a.frag:3: scene is lowp, as no precision is declared"),
        ("#version 100\nuniform samplerCube sky;\n", "a.frag:2: sky is lowp"),
        ("#version 310 es\n\nprecision mediump float;\n", "a.frag:3: mediump is declared"),
        ("#version 300 es\nprecision highp sampler2D;\n" + HIGH, ""),
        ("#version 300 es\n" + HIGH.replace("sampler", "highp sampler"), ""),
        ("#version 300 es\n// mediump, lowp\nprecision highp float;\n", ""),
        ("#version 330 core\nuniform mediump float x;\nuniform sampler2D scene;\n", ""),
        (HIGH, "a.frag:2: scene is lowp"),
        (HIGH.splitlines()[1] + "\n", ""),
    ],
)
def test_what_is_below_highp(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "a.frag").write_text(text + "void main() {}\n")
    found = find_below_highp(Shaders([tmp_path]).load("a.frag"))
    assert said in found and bool(said) == bool(found)
