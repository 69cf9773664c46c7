"""Laws judged on real runs: what a shader must do while an input or a uniform varies."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Case,
    Ramp,
    bounded,
    fullscreen,
    monotone,
    symmetric,
)
from shaderlab.engine.expectations.laws import OutputLaw as Law
from shaderlab.engine.run import SceneRunner
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Outcome

SHADER = """#version 330 core
in vec3 lightDir; in vec2 a; in vec2 b; in float x;
uniform float gain; uniform float slip;
out vec3 brdf; out float attenuation; out float product; out float noise;
void main() {
    brdf = vec3(gain / 3.14159265, 0.25, 0.4 * max(lightDir.z, 0.0));
    attenuation = 1.0 / (1.0 + 0.09 * x + 0.032 * x * x) + slip * x;
    product = dot(a, b) + slip * a.x;
    noise = fract(sin(dot(vec2(x, 0.5 * x), vec2(12.9898, 78.233))) * 43758.5453) + slip;
}
"""


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=8)) as made:
        yield made


def judged(lab: SceneRunner, folder: Path, check: Law, **uniforms: float) -> Outcome:
    (folder / "laws.frag").write_text(SHADER)
    passes = fullscreen(
        "laws.frag",
        domain={"lightDir": Ramp((0.0, 0.0, 1.0)), "a": Ramp((1.0, 2.0)), "b": Ramp((3.0, 4.0)),
                "x": Ramp(1.0)},
        uniforms={"gain": 1.0, "slip": 0.0} | uniforms,
    )  # fmt: skip
    case = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=[check])
    record = lab.run(case.scene("default"))
    assert record.expectations, record.message
    return record.expectations[0]


DISTANCES = np.linspace(0.0, 50.0, 501).tolist()
PAIRS = [((x, 1.0), (0.5, -x)) for x in np.linspace(-3.0, 3.0, 25)]
CHECKS: list[tuple[Law, dict[str, float]]] = [
    (monotone("attenuation", over="x", values=DISTANCES, direction="decreasing"), {"slip": 0.001}),
    (bounded("attenuation", 0.0, 1.0, over="x", values=DISTANCES), {"slip": 0.1}),
    (symmetric("product", over=("a", "b"), values=PAIRS), {"slip": 0.001}),
    (bounded("attenuation", 0.0, 1.0, over="slip", values=(0.0, 0.0)), {}),
]


@pytest.mark.parametrize("check", [check for check, _ in CHECKS], ids=lambda c: c.name)
def test_laws_hold(lab: SceneRunner, tmp_path: Path, check: Law) -> None:
    outcome = judged(lab, tmp_path, check)
    assert outcome.status == "pass", outcome


@pytest.mark.parametrize(
    ("check", "wrong"), [pair for pair in CHECKS if pair[1]], ids=lambda c: getattr(c, "name", "")
)
def test_laws_are_broken_by_a_slip(
    lab: SceneRunner, tmp_path: Path, check: Law, wrong: dict[str, float]
) -> None:
    outcome = judged(lab, tmp_path, check, **wrong)
    assert outcome.status == "fail", outcome
    shown = outcome.rows or (outcome.worst is not None and outcome.worst.inputs)
    assert shown, "neither rows nor the inputs of the worst value"


def test_a_uniform_can_be_what_varies(lab: SceneRunner, tmp_path: Path) -> None:
    check: Any = monotone("brdf", over="gain", values=(0.5, 1.0, 2.0))
    assert judged(lab, tmp_path, check).status == "pass"
    falling: Any = monotone("brdf", over="gain", values=(0.5, 1.0, 2.0), direction="decreasing")
    assert judged(lab, tmp_path, falling).status == "fail"
