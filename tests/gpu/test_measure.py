"""Measures on a driver: over several passes, in the record, and as what kills a mutant."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import Case, Output, across, formula, fullscreen, measure, reading, value
from shaderlab.engine.catalogue import load_case
from shaderlab.engine.run import SceneRunner
from shaderlab.model.options import RunOptions
from shaderlab.mutation import MutationPlan, make_mutants
from shaderlab.mutation.judging import Judge

STEP = """\
#version 330 core
in float x;
uniform float edge;
out float lit;
void main() { lit = x < edge ? 0.0 : 1.0; }
"""
HALF = """\
#version 330 core
in vec2 TexCoords;
uniform sampler2D map;
out vec4 FragColor;
void main() { FragColor = vec4(texture(map, TexCoords).r * 0.5); }
"""
ARRAY = """\
#version 330 core
in float x;
uniform vec2 places[3];
out vec2 nearest;
void main()
{
    nearest = places[0] + x * places[1] + places[2];
}
"""
CASE = '''\
"""A step."""
from shaderlab import Case, Output, across, fullscreen, measure


def share(lit):
    """The lit share."""
    return lit.mean()


case = Case(
    title="A step",
    passes=(
        *fullscreen(
            "step.frag", name="near", domain={"x": across(0.0, 1.0)}, uniforms={"edge": 0.25}
        ),
        *fullscreen("half.frag", name="far", textures={"map": Output("near.lit")}),
    ),
    expect=[measure("lit", share, reads={"lit": "near.lit"}, between=(0.7, 0.8))],
)
'''


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in {"step.frag": STEP, "half.frag": HALF, "array.frag": ARRAY}.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "step.py").write_text(CASE)
    return tmp_path


@pytest.fixture
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16)) as made:
        yield made


def two_passes() -> Any:
    near = fullscreen(
        "step.frag", name="near", domain={"x": across(0.0, 1.0)}, uniforms={"edge": 0.25}
    )
    return (*near, *fullscreen("half.frag", name="far", textures={"map": Output("near.lit")}))


def run(lab: SceneRunner, folder: Path, passes: Any, *expect: Any) -> Any:
    case = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=expect)
    return lab.run(case.scene("default"))


def lost(near_lit: Any, FragColor: Any, times: float) -> Any:
    return (near_lit[..., 0] - times * FragColor[..., 0]).mean()


def test_a_measure_reads_every_pass_and_is_in_the_record(lab: SceneRunner, folder: Path) -> None:
    rows = [reading(1, given={"times": 1.0}, at_most=0.4), reading(2, given={"times": 2.0})]
    record = run(lab, folder, two_passes(), measure("lost", lost, readings=rows))
    assert record.status == "pass", record
    (outcome,) = record.expectations
    assert [row.measured for row in outcome.rows] == ["0.375", "0"]
    assert [(p.x, p.y, p.ok) for p in record.plots[0].points] == [
        (1.0, 0.375, True),
        (2.0, 0.0, True),
    ]


def test_a_missed_threshold_fails_the_case(lab: SceneRunner, folder: Path) -> None:
    record = run(
        lab, folder, two_passes(), measure("lost", lost, given={"times": 1.0}, at_most=0.3)
    )
    assert record.status == "fail"
    assert record.expectations[0].message == "measured 0.375, expected ≤ 0.3"


def test_a_wrong_name_is_an_error_of_its_expectation(lab: SceneRunner, folder: Path) -> None:
    def misspelt(near_list: Any) -> Any:
        return near_list.mean()

    record = run(lab, folder, two_passes(), measure("m", misspelt, at_most=1.0))
    assert record.status == "error"
    assert "did you mean near_lit?" in record.expectations[0].message


def test_a_mutant_that_breaks_a_bound_is_killed(folder: Path) -> None:
    case = load_case(folder / "step.py")
    with SceneRunner(RunOptions(size=16)) as lab:
        judge = Judge(lab, case)
        fates = {m.text: judge.judge(m) for m in make_mutants(case, MutationPlan(state=False))}
    turned = [fate for text, fate in fates.items() if "x > edge" in text or "x >= edge" in text]
    assert turned and all(fate.status == "killed" and "lit" in fate.by for fate in turned)
    # What only the second pass draws, no expectation reads.
    others = [fate for text, fate in fates.items() if "texture(" in text]
    assert others and not any(fate.status == "killed" for fate in others)


def test_an_array_given_to_a_value_reaches_its_reference_as_a_list(
    lab: SceneRunner, folder: Path
) -> None:
    def nearest(x: Any, places: Any) -> Any:
        assert isinstance(places, list) and len(places) == 3
        return places[0] + x * places[1] + places[2]

    passes = fullscreen(
        "array.frag",
        domain={"x": across(0.0, 1.0)},
        uniforms={"places": np.arange(6.0).reshape(3, 2)},
    )
    record = run(
        lab,
        folder,
        passes,
        formula("nearest", nearest),
        value(
            "nearest",
            at={"x": 2.0, "places": [(0.1, 0.2), (0.3, 0.4), (0.5, 0.6)]},
            equals=(1.2, 1.6),
            digits=6,
        ),
    )
    assert record.status == "pass", record.expectations
