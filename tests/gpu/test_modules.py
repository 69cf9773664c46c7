"""Each draw judged by its own shader: what a driver gets wrong is caught where no formula looks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from shaderlab import Blend, Case, Cell, Ramp, State, coverage, fullscreen
from shaderlab.analysis import proof, self_check
from shaderlab.analysis.self_check import SelfCheck
from shaderlab.drivers.opengl import linking
from shaderlab.drivers.passes import PassSession
from shaderlab.engine.run import SceneRunner
from shaderlab.model.options import RunOptions

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
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16, modules=True)) as found:
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


def test_outputs_that_nothing_looks_at_are_judged(lab: SceneRunner, case: Case) -> None:
    (scene,) = case.scenes()
    outcome = lab.run(scene).expectations[-1]
    assert (outcome.kind, outcome.status, outcome.judged) == ("module", "pass", 2 * 256)


def test_what_is_proved_of_a_program_is_said(lab: SceneRunner, case: Case) -> None:
    x, divided = "place.x", "second = vec4(1.0 / (place.x * place.x - place.x + 0.5));"
    shader = SHADER.replace(f"sqrt({x})", f"sqrt({x} - 0.5)").replace(
        "second = vec4(place, 0.25, 0.5);", divided
    )
    Path(case.file).with_name("two.frag").write_text(shader)
    with SceneRunner(RunOptions(size=16)) as one_box:
        first, closer = (runner.run(case.scene("default")).modules for runner in (one_box, lab))
    assert first is not None and closer is not None
    for found in (first, closer):
        assert any("no sqrt of a negative number" in claim for claim in found.open)
    assert not any("no sqrt" in claim for claim in (*first.proved, *closer.proved))
    division = "no division by 0"
    assert any(division in claim for claim in first.open)
    assert any(division in claim for claim in closer.proved)


def test_a_defect_of_a_proof_changes_no_verdict(
    case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("SHADERLAB_DEBUG", raising=False)
    monkeypatch.setattr(proof, "BoxWatcher", lambda *given: 1 / 0)
    with SceneRunner(RunOptions(size=16)) as lab:
        record = lab.run(case.scene("default"))
    assert record.status == "pass" and record.modules is not None
    assert record.modules.judged and not record.modules.proved


def test_one_wrong_pixel_is_found_and_named(lab: SceneRunner, case: Case) -> None:
    (scene,) = case.scenes()
    with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
        key = (scene.passes[0].name, "second")
        values = evaluation.drawn.images[key].values.copy()
        values[5, 3, 2] += 1e-6
        wrong = {key: replace(evaluation.drawn.images[key], values=values)}
        evaluation.drawn = replace(evaluation.drawn, images={**evaluation.drawn.images, **wrong})
        outcome = SelfCheck(evaluation, every=True).judgement()[1].outcome
    assert (outcome.status, outcome.outside) == ("fail", 1)
    assert "second is 0." in outcome.message and "at pixel (3, 5)" in outcome.message


def test_codes_are_told_in_codes(lab: SceneRunner, case: Case) -> None:
    (drawn,) = case.passes
    target = replace(drawn.target, colors={"color": "rgba8", "second": "rgba8"})
    (scene,) = replace(case, passes=(replace(drawn, target=target),)).scenes()
    with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
        key = (scene.passes[0].name, "second")
        values = evaluation.drawn.images[key].values.copy()
        code = int(values[5, 3, 2])
        values[5, 3, 2] = code + (1 if code < 255 else -1)
        wrong = {key: replace(evaluation.drawn.images[key], values=values)}
        evaluation.drawn = replace(evaluation.drawn, images={**evaluation.drawn.images, **wrong})
        outcome = SelfCheck(evaluation, every=True).judgement()[1].outcome
    assert outcome.status == "fail" and f", {code} … {code}" in outcome.message


@pytest.mark.parametrize("state", [State(), State(blend=Blend(source="one", destination="one"))])
def test_a_miscompiled_output_that_no_formula_looks_at_turns_the_run_red(
    case: Case, monkeypatch: pytest.MonkeyPatch, state: State
) -> None:
    (drawn,) = case.passes
    passes = (replace(drawn, draws=(replace(drawn.draws[0], state=state),)),)
    case = replace(case, passes=passes, expect=(coverage(64 * 64),))
    (scene,) = case.scenes()
    with SceneRunner(RunOptions()) as lab:
        right = lab.run(scene)
        # This driver takes a half for a quarter wherever place.y is large.
        verbatim = linking.Linker.link
        monkeypatch.setattr(
            linking.Linker, "link",
            lambda self, texts, **more: verbatim(self, miscompiled(texts), **more),
        )  # fmt: skip
        wrong = lab.run(scene)
    assert right.modules is not None
    assert right.modules.outputs == ("main.color", "main.second")
    assert right.modules.judged == 2 * 1026
    assert (right.status, [one.kind for one in right.expectations]) == ("pass", ["coverage"])
    outcome = wrong.expectations[-1]
    assert (wrong.status, outcome.kind, outcome.status) == ("fail", "module", "fail")
    assert "is outside its shader's band: second is" in outcome.message


def test_a_draw_is_made_again_without_those_after_it(
    case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For a driver, each state of a draw is a program to compile."""
    (drawn,) = case.passes
    blend = Blend(source="one", destination="one")
    draws = tuple(
        replace(
            drawn.draws[0],
            state=State(blend=blend, cell=Cell(column=k, row=0, columns=4, rows=1)),
        )
        for k in range(4)
    )
    case = replace(case, passes=(replace(drawn, draws=draws),))
    (scene,) = case.scenes()
    verbatim, counts = PassSession.redraw_with_texts, list[int]()

    def redraw(self: Any, description: Any, target: Any, texts: Sequence[str]) -> Any:
        counts.append(len(texts))
        return verbatim(self, description, target, texts)

    monkeypatch.setattr(PassSession, "redraw_with_texts", redraw)
    with SceneRunner(RunOptions(size=16, modules=True)) as lab:
        record = lab.run(scene)
    outcome = record.expectations[-1]
    assert (outcome.kind, outcome.status) == ("module", "pass")
    assert record.modules is not None and record.modules.judged == 2 * 16 * 16
    assert counts == [4, 1, 2, 3, 4]  # all are captured together, then each is made again


def miscompiled(texts: Mapping[str, str]) -> dict[str, str]:
    return {k: t.replace("0.25, 0.5", "place.y > 0.9 ? 0.5 : 0.25, 0.5") for k, t in texts.items()}


def test_no_modules_judges_none(case: Case) -> None:
    (scene,) = case.scenes()
    with SceneRunner(RunOptions(size=16, modules=False)) as lab:
        record = lab.run(scene)
    assert (record.modules, [one.kind for one in record.expectations]) == (None, ["coverage"])


def test_a_defect_of_the_interpreter_changes_no_verdict(
    lab: SceneRunner, case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    (scene,) = case.scenes()
    monkeypatch.delenv("SHADERLAB_DEBUG", raising=False)
    monkeypatch.setattr(self_check, "interpret", lambda *_, **__: {}["nothing"])
    record = lab.run(scene)
    assert record.status == "pass" and record.modules is not None
    assert record.modules.left_out == (
        "draw 0 of pass 'main': not interpreted: unforeseen KeyError('nothing')",
    )
