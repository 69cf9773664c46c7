"""The draws of a pass are captured at once where that can be, and each gets what it gets alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import Case, Depth, Draw, Mesh, Pass, State, Target, coverage, formula
from shaderlab.drivers.programs import stages
from shaderlab.drivers.programs.captures import PassCapture
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import vec4
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, Fragments
from shaderlab.model.options import RunOptions

VERTEX = """#version 330 core
in vec3 place; uniform float turn; out vec2 uv; flat out int id; out vec3 more;
void main() {
    uv = place.xy * turn; id = int(turn * 8.0); more = place + turn;
    gl_Position = vec4(place, 1.0 + 0.25 * place.x);
}
"""
FRAGMENTS = {
    "plain": "in vec2 uv; uniform vec2 by; out vec4 color;\n"
    "void main() { color = vec4(uv * by, 0.0, 1.0); }",
    "longer": "in vec2 uv; in vec3 more; out vec4 color;\n"
    "void main() { color = vec4(more, uv.x); }",
    "whole": "flat in int id; out vec4 color;\nvoid main() { color = vec4(id); }",
    "holes": "in vec2 uv; out vec4 color;\n"
    "void main() { if (fract(4.0 * uv.x) < 0.5) discard; color = vec4(uv, 0.0, 1.0); }",
}
DRAWS = ("plain", "longer", "plain", "whole", "holes", "plain")


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=24)) as made:
        yield made


def scene_of(folder: Path, state: State) -> Scene:
    (folder / "any.vert").write_text(VERTEX)
    for name, text in FRAGMENTS.items():
        (folder / f"{name}.frag").write_text(f"#version 330 core\n{text}\n")
    draws = []
    for number, name in enumerate(DRAWS):
        corner = np.array([-1.0 + 0.25 * number, 0.9 - 0.3 * number])
        flat = corner + np.array([[0.0, 0.0], [1.1, 0.1], [0.2, -0.9]])
        place = np.column_stack([flat, [0.3, -0.4, 0.1 * number]]).astype(np.float32)
        uniforms: dict[str, Any] = {"turn": 1.0 + 0.25 * number}
        if name == "plain":
            uniforms["by"] = (0.5, 2.0)
        mesh = Mesh(attributes={"place": place})
        draws.append(
            Draw(vertex="any.vert", fragment=f"{name}.frag", mesh=mesh, uniforms=uniforms,
                 state=state)
        )  # fmt: skip
    passes = [Pass(name="main", draws=draws, target=Target(depth="depth24"))]
    check = coverage(0)
    case = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=[check])
    return case.scene("default")


Captured = tuple[list[Fragments], list[Fragments], int]


def captured(
    lab: SceneRunner, scene: Scene, change: Callable[[str], str] = lambda text: text
) -> Captured:
    """Each draw's fragments from one capture of the pass and from one of its own, and how often
    the former redrew; `change` is made to the texts of the former."""
    with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
        session: Any = evaluation.session
        draws, numbers = session.programs["main"], range(len(DRAWS))
        redraw = session._capture("main")._redraw
        count = 0

        def changed(texts: Sequence[str], colors: Mapping[str, str]) -> Mapping[str, Array]:
            nonlocal count
            count += 1
            found: Mapping[str, Array] = redraw([change(text) for text in texts], colors)
            return found

        together, alone = PassCapture(draws, changed), PassCapture(draws, redraw)
        alone._together = {number: alone._capture_alone(number) for number in numbers}
        made = [together.fragments(number) for number in numbers]
        return made, [alone.fragments(number) for number in numbers], count


def alike(one: Fragments, other: Fragments) -> bool:
    pairs = [(one.covered, other.covered), (one.frag_coord, other.frag_coord)]
    pairs += [(values[one.covered], other.inputs[name][one.covered])
              for name, values in one.inputs.items()]  # fmt: skip
    return one.inputs.keys() == other.inputs.keys() and all(np.array_equal(a, b) for a, b in pairs)


@pytest.mark.parametrize("state", [State(), State(depth=Depth(func="less"))])
def test_together_as_alone(lab: SceneRunner, tmp_path: Path, state: State) -> None:
    together, alone, redraws = captured(lab, scene_of(tmp_path, state))
    assert all(fragments.covered.any() for fragments in alone)
    assert all(alike(a, b) for a, b in zip(together, alone, strict=True))
    # Five at once, the one with integers alone, and the one that discards once more, all kept.
    assert redraws == 3
    kept = [fragments.undiscarded is not None for fragments in together]
    assert kept == [name == "holes" for name in DRAWS]


def test_a_wrong_number_would_be_noticed(lab: SceneRunner, tmp_path: Path) -> None:
    def change(text: str) -> str:
        return text.replace(f"= {stages.NUMBER};", "= 1.0;")

    together, alone, _ = captured(lab, scene_of(tmp_path, State()), change)
    assert not all(alike(a, b) for a, b in zip(together, alone, strict=True))


def test_a_draw_that_the_driver_refuses_hinders_no_other(lab: SceneRunner, tmp_path: Path) -> None:
    def change(text: str) -> str:
        refused = "more" in text and stages.NUMBERED in text
        return text.replace("void main() {\n", "void main() { no_such();\n") if refused else text

    together, alone, _ = captured(lab, scene_of(tmp_path, State()), change)
    assert all(alike(a, b) for a, b in zip(together, alone, strict=True))


@pytest.mark.parametrize("off", [(0.0, 1.0), (-1.0, 0.0), (np.nan, 0.0), (0.0, 0.0)])
def test_a_driver_with_another_idea_of_places_is_found_out(
    lab: SceneRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, off: tuple[float, float]
) -> None:
    captured = PassCapture.fragments

    def shifted(self: PassCapture, index: int) -> Fragments:
        found = captured(self, index)
        return replace(found, frag_coord=found.frag_coord + np.float32([*off, 0.0, 0.0]))

    monkeypatch.setattr(PassCapture, "fragments", shifted)
    scene = scene_of(tmp_path, State())
    check = formula("main.color", lambda uv, by: vec4(uv * by, 0.0, 1.0), draw=0)
    first = [replace(scene.passes[0], draws=scene.passes[0].draws[:1])]
    (outcome,) = lab.run(replace(scene, passes=first, expect=[check])).expectations
    expected = "pass" if off == (0.0, 0.0) else "fail"
    assert outcome.status == expected, outcome.message
    assert ("the driver is wrong: gl_FragCoord is (" in outcome.message) == (expected == "fail")
