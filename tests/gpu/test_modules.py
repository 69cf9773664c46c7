"""Each draw judged by its own shader: what a driver gets wrong is caught where no formula looks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from shaderlab import Case, Ramp, coverage, fullscreen
from shaderlab.evaluation import Lab
from shaderlab.evaluation.modules import judge_modules
from shaderlab.options import RunOptions

SHADER = """#version 330 core
in vec2 place;
out vec4 color;
out vec4 second;
void main()
{
    color = vec4(sqrt(place.x), place.y, 0.0, 1.0);
    second = vec4(place, 0.25, 0.5);
}
"""


@pytest.fixture(scope="module")
def lab() -> Iterator[Lab]:
    with Lab(RunOptions(size=16, modules=True)) as found:
        yield found


@pytest.fixture
def case(tmp_path: Path) -> Case:
    (tmp_path / "two.frag").write_text(SHADER)
    return Case(
        title="t", id="t", file=str(tmp_path / "t.py"),
        passes=fullscreen(
            "two.frag", domain={"place": Ramp((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))}
        ),
        expect=[coverage(256)],
    )  # fmt: skip


def test_outputs_that_nothing_looks_at_are_judged(lab: Lab, case: Case) -> None:
    (scene,) = case.scenes()
    outcome = lab.run(scene).expectations[-1]
    assert (outcome.kind, outcome.status, outcome.judged) == ("module", "pass", 2 * 256)


def test_one_wrong_pixel_is_found_and_named(lab: Lab, case: Case) -> None:
    (scene,) = case.scenes()
    with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
        key = (scene.passes[0].name, "second")
        values = evaluation.drawn.images[key].values.copy()
        values[5, 3, 2] += 1e-6
        wrong = {key: replace(evaluation.drawn.images[key], values=values)}
        evaluation.drawn = replace(evaluation.drawn, images={**evaluation.drawn.images, **wrong})
        outcome = judge_modules(evaluation).outcome
    assert (outcome.status, outcome.outside) == ("fail", 1)
    assert "second is 0." in outcome.message and "at pixel (3, 5)" in outcome.message


def test_without_the_option_there_is_no_such_outcome(case: Case) -> None:
    (scene,) = case.scenes()
    with Lab(RunOptions(size=16)) as lab:
        assert [one.kind for one in lab.run(scene).expectations] == ["coverage"]
