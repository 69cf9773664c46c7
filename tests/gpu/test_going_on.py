"""A pass may go on in an earlier one's target, and nobody may read what it drew over."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from shaderlab.engine.expectations.exact import exact
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError
from shaderlab.model.case import Case
from shaderlab.model.records import Record
from shaderlab.model.scene import Pass, Target, fullscreen
from shaderlab.model.state import Blend, State
from shaderlab.model.textures import Output

PLAIN = """\
#version 330 core
uniform float level;
out vec4 FragColor;
void main() { FragColor = vec4(level); }
"""
READS = """\
#version 330 core
uniform sampler2D image;
out vec4 FragColor;
void main() { FragColor = texelFetch(image, ivec2(0), 0); }
"""
SUM = State(blend=Blend(source="one", destination="one"))
SMALL = Target(size=(4, 4))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "plain.frag").write_text(PLAIN)
    (tmp_path / "reads.frag").write_text(READS)
    return tmp_path


def adds(name: str, level: float, onto: str = "", target: Target = SMALL) -> Pass:
    draws = fullscreen("plain.frag", domain={}, uniforms={"level": level}, state=SUM)[0].draws
    return Pass(name=name, target=target, draws=draws, onto=onto)


def reads(name: str, source: str, onto: str = "") -> Pass:
    textures = {"image": Output(f"{source}.FragColor")}
    draws = fullscreen("reads.frag", domain={}, textures=textures)[0].draws
    return Pass(name=name, target=SMALL, draws=draws, onto=onto)


def run(folder: Path, *passes: Pass, **checks: float) -> Record:
    case: dict[str, Any] = {"title": "t", "id": "t", "file": str(folder / "t.py")}
    expect = [exact(f"{name}.FragColor", (level,) * 4) for name, level in checks.items()]
    with SceneRunner() as lab:
        return lab.run(Case(passes=passes, expect=expect, **case).scene("default"))


def test_draws_go_on_where_the_pass_before_stopped(folder: Path) -> None:
    record = run(
        folder, adds("a", 0.25), reads("early", "a"), adds("b", 0.5, onto="a"),
        adds("c", 1.0, onto="b"), reads("late", "c"),
        a=0.25, early=0.25, b=0.75, c=1.75, late=1.75,
    )  # fmt: skip
    assert record.status == "pass", record


@pytest.mark.parametrize(
    ("passes", "message"),
    [
        ((adds("a", 1.0), adds("b", 1.0, onto="a"), reads("c", "a")), "pass 'a' was drawn over"),
        ((adds("a", 1.0), reads("b", "a", onto="a")), "reads 'image' from the target it draws"),
        ((adds("b", 1.0, onto="a"),), "continues 'a', which is no earlier pass"),
        (
            (adds("a", 1.0), adds("b", 1.0, onto="a", target=Target(size=(8, 8)))),
            "continues 'a', but its target differs",
        ),
    ],
)
def test_what_can_not_be_read_any_more(
    folder: Path, passes: tuple[Pass, ...], message: str
) -> None:
    record = run(folder, *passes, **{passes[-1].name: 1.0})
    assert record.status == "error"
    assert message in record.message


def test_depth_and_samples_can_not_be_gone_on_with() -> None:
    for target in (Target(size=(4, 4), depth="depth24"), Target(size=(4, 4), samples=4)):
        with pytest.raises(CaseError, match="could not be captured alone"):
            adds("b", 1.0, onto="a", target=target)
