"""Outputs that no expectation reads are named: whatever is drawn there, a case passes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from shaderlab.engine.expectations.exact import exact
from shaderlab.engine.expectations.figures import value
from shaderlab.engine.expectations.formula import formula
from shaderlab.engine.run import SceneRunner
from shaderlab.model.case import Case
from shaderlab.model.expectation import Expectation
from shaderlab.model.scene import Pass, Pixel, Target, fullscreen
from shaderlab.model.textures import Output

TWO = """\
#version 330 core
uniform float level;
layout(location = 0) out vec4 FragColor;
layout(location = 1) out float half_;
void main() { FragColor = vec4(level); half_ = level / 2.0; }
"""
READS = """\
#version 330 core
uniform sampler2D image;
out vec4 FragColor;
void main() { FragColor = texelFetch(image, ivec2(0), 0); }
"""
SMALL = Target(size=(4, 4))


def flat(level: float) -> float:
    return level


def drawn(name: str, draws: int = 1, onto: str = "", target: Target = SMALL) -> Pass:
    one = fullscreen("two.frag", domain={}, uniforms={"level": 0.5})[0].draws
    return Pass(name=name, target=target, draws=one * draws, onto=onto)


def reader(source: str) -> Pass:
    textures = {"image": Output(source)}
    draws = fullscreen("reads.frag", domain={}, textures=textures)[0].draws
    return Pass(name="reader", target=SMALL, draws=draws)


@pytest.fixture
def unread(tmp_path: Path) -> Any:
    (tmp_path / "two.frag").write_text(TWO)
    (tmp_path / "reads.frag").write_text(READS)

    def run(passes: list[Pass], *expect: Expectation) -> tuple[str, ...]:
        case = Case(
            title="t", id="t", file=str(tmp_path / "t.py"), passes=tuple(passes), expect=expect
        )
        with SceneRunner() as lab:
            record = lab.run(case.scene("default"))
        assert record.status == "pass", record.message
        return record.unread

    return run


def test_what_is_read_whole_is_not_named(unread: Any) -> None:
    both = formula("FragColor", flat), exact("half_", 0.25)
    assert unread([drawn("main")], *both) == ()
    assert unread([drawn("main")], both[0]) == ("main.half_",)


def test_a_pixel_is_not_the_whole(unread: Any) -> None:
    one = value("half_", reference=lambda level: level / 2, equals=0.25, digits=2, at=Pixel(1, 1))
    assert unread([drawn("main")], exact("FragColor", 0.5), one) == ("main.half_",)


def test_each_draw_is_read_by_itself(unread: Any) -> None:
    last = formula("FragColor", flat), exact("half_", 0.25)
    assert unread([drawn("main", draws=2)], *last) == ("main.FragColor of draw 0",)
    first = formula("FragColor", flat, draw=1), formula("half_", lambda level: level / 2)
    assert unread([drawn("main", draws=2)], *first) == (
        "main.FragColor of draw 0",
        "main.half_ of draw 0",
    )


def test_what_a_read_pass_reads_is_read(unread: Any) -> None:
    check = exact("reader.FragColor", 0.5)
    assert unread([drawn("main"), reader("main.FragColor")], check) == ("main.half_",)
    assert unread(
        [drawn("main"), reader("main.half_"), drawn("other")],
        exact("reader.FragColor", (0.25, 0, 0, 1)),
    ) == ("main.FragColor", "other.FragColor", "other.half_")


def test_what_another_pass_goes_on_in_is_read_with_it(unread: Any) -> None:
    passes = [drawn("main"), drawn("more", onto="main")]
    assert unread(passes, exact("more.FragColor", 0.5)) == ("main.half_", "more.half_")


def test_what_is_stored_nowhere_can_not_be_read(unread: Any) -> None:
    alone = Target(size=(4, 4), colors={"FragColor": "rgba32f"})
    assert unread([drawn("main", target=alone)], exact("FragColor", 0.5)) == ()
