"""Scores, JSON, and mutants of fixed-function state."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest

from shaderlab.cli.mutate import _is_too_low
from shaderlab.engine.expectations.exact import exact
from shaderlab.engine.jobs import Executor
from shaderlab.engine.pictures import with_read_passes
from shaderlab.errors import ShaderError
from shaderlab.model.case import Case
from shaderlab.model.mesh import Mesh
from shaderlab.model.scene import Draw, Pass, Target, mesh_pass
from shaderlab.model.state import Blend, Depth, State, Stencil
from shaderlab.model.textures import CubeTexture, Output, TextureArray
from shaderlab.mutation import (
    CaseResult,
    MutantResult,
    MutantRun,
    ShaderMutant,
    results_to_json,
    score,
)
from shaderlab.mutation.campaign import CaseTarget, JudgeMutant, MutationPlan, MutationRun
from shaderlab.mutation.mutants import STATE, Status, with_readers
from shaderlab.mutation.state_mutants import mutate_state
from shaderlab.workers.pool import ItemResult


def tried(status: Status, operator: str = "operator", line: int = 7) -> MutantRun:
    mutant = ShaderMutant(
        file="shaders/lamp.frag", line=line, operator=operator, before="a + b", after="a - b",
        program=("lamp.frag",), shader="lamp.frag", stage="fragment", text="",
    )  # fmt: skip
    return MutantRun(mutant, MutantResult(status=status, by="default · factor"))


def result(*statuses: Status) -> CaseResult:
    return CaseResult(id="lamp", runs=tuple(tried(s) for s in statuses), seconds=1.5)


def test_the_score_leaves_out_what_nobody_could_notice() -> None:
    one = result("killed", "killed", "killed", "survived", "equivalent", "invalid", "no difference")
    assert one.score == 0.75
    assert score([one], state=True) is None
    assert result("equivalent", "invalid").score is None


def test_what_was_killed_has_an_example_of_each_kind() -> None:
    edit = ("lamp.frag", 9, 4, "+", "-")
    kinds = ("operator", "operator", "swizzle")
    runs = [tried("killed", kind, line) for line, kind in enumerate(kinds)]
    runs = [replace(each, mutant=replace(each.mutant, text_edit=edit)) for each in runs]
    runs.append(tried("killed", STATE))  # of no text
    (case,) = results_to_json([CaseResult(id="lamp", runs=tuple(runs), seconds=1.5)])["cases"]
    assert [(each["operator"], each["line"]) for each in case["examples"]] == [
        ("operator", 1),
        ("swizzle", 2),
    ]
    assert case["examples"][0]["edit"] == list(edit)


class Prepared:
    """An executor that makes no mutants of one case, and judges those of the others."""

    def __init__(self, failure: dict[str, Any]) -> None:
        self.failure = failure

    def perform(self, requests: Sequence[Any]) -> Iterator[ItemResult]:
        for number, request in enumerate(requests):
            if isinstance(request, JudgeMutant):
                yield ItemResult(number, request, "done", MutantResult("killed", "by"))
            elif request.id == "wrong":
                yield ItemResult(number, request, **self.failure)
            else:
                yield ItemResult(number, request, "done", [tried("killed").mutant])


@pytest.mark.parametrize(
    ("failure", "said"),
    [
        (
            {"status": "timeout", "message": "took longer than 20 s"},
            "making its mutants: took longer than 20 s\n→ allow more time: --timeout S",
        ),
        (
            {"status": "crash", "message": "the process died"},
            "making its mutants: the process died",
        ),
        ({"status": "error", "value": ShaderError("no a.frag")}, "no a.frag"),
        ({"status": "error", "value": KeyError("a")}, "unforeseen KeyError: 'a'"),
        ({"status": "error", "value": MemoryError()}, "out of memory"),
    ],
)
def test_a_case_without_mutants_stops_no_other(failure: dict[str, Any], said: str) -> None:
    targets = [CaseTarget(Path(i), i, MutationPlan()) for i in ("wrong", "lamp")]
    run = MutationRun(targets, cast(Executor, Prepared(failure)))
    assert [case_id for case_id, _ in run.judge()] == ["lamp"]
    wrong, lamp = run.results()
    assert (wrong.message, wrong.runs, lamp.message, lamp.score) == (said, (), "", 1.0)


def test_no_score_reaches_what_is_no_number() -> None:
    scores = [(0.5, 50.0), (1.0, math.nan), (None, 0.0), (1.0, None)]
    assert [_is_too_low(*each) for each in scores] == [False, True, True, False]


def test_state_has_a_score_of_its_own() -> None:
    one = CaseResult(
        id="lamp", runs=(tried("killed"), tried("survived", operator=STATE)), seconds=0.0
    )
    assert (one.score, score([one], state=True)) == (1.0, 0.0)


def test_json_names_each_survivor_s_place() -> None:
    one = result("killed", "survived", "no difference", "invalid")
    data = json.loads(json.dumps(results_to_json([one])))
    assert data["score"] == 0.5
    (case,) = data["cases"]
    assert {k: case[k] for k in ("id", "killed", "invalid", "equivalent", "score")} == {
        "id": "lamp", "killed": 1, "invalid": 1, "equivalent": 0, "score": 0.5,
    }  # fmt: skip
    assert case["seconds"] == 1.5
    entry = {"file": "shaders/lamp.frag", "line": 7, "operator": "operator", "before": "a + b",
             "after": "a - b", "program": ["lamp.frag"], "note": "default · factor"}  # fmt: skip
    assert case["survived"] == case["no_difference"] == [entry]


def case_of(state: State, draws: int = 1) -> Case:
    (one,) = mesh_pass("a.vert", "a.frag", Mesh(attributes={"aPos": [[0.0]]}), state=state)
    many = (replace(one.draws[0], state=replace(state)) for _ in range(draws))
    passes = (Pass(name="main", draws=tuple(many)),)
    return Case(title="t", passes=passes, expect=[exact("c", 1.0)])


def changes(state: State) -> set[tuple[str, object]]:
    return {(m.path, m.new) for m in mutate_state(case_of(state))}


def test_mistakes_in_state() -> None:
    assert changes(State()) == set()
    assert changes(State(depth=Depth())) == {
        ("depth", None), ("depth.write", False), ("depth.func", "lequal"),
        ("depth.func", "greater"),
    }  # fmt: skip
    assert changes(State(cull="back")) == {("cull", "front"), ("cull", None), ("front_face", "cw")}
    stencil = changes(State(stencil=Stencil(func="equal", depth_pass="incr", mask=3)))
    assert {
        ("stencil", None), ("stencil.func", "notequal"), ("stencil.depth_pass", "decr"),
        ("stencil.mask", 0), ("stencil.mask", 2), ("stencil.reference", 1),
        ("stencil.write_mask", 0),
    } <= stencil  # fmt: skip
    blend = changes(State(blend=Blend()))
    assert {
        ("blend", None), ("blend.source", "one"), ("blend.source", "one_minus_src_alpha"),
        ("blend.destination", "src_alpha"), ("blend.equation", "subtract"),
    } <= blend  # fmt: skip


def test_mistakes_in_what_covers_which_pixels() -> None:
    state = State(depth_range=(0.25, 1.0), polygon_offset=(0.0, -2.0), point_size=3.0)
    assert changes(state) == {
        ("depth_range", (0.0, 1.0)), ("depth_range", (1.0, 0.25)), ("polygon_offset", None),
        ("polygon_offset", (0.0, 2.0)), ("polygon_offset", (0.0, 0.0)), ("point_size", 1.0),
        ("point_size", 4.0),
    }  # fmt: skip
    samples = State(
        point_size="program", multisample=False, sample_shading=1.0, alpha_to_coverage=True
    )
    assert changes(samples) == {
        ("point_size", 1.0), ("multisample", True), ("sample_shading", None),
        ("alpha_to_coverage", False),
    }  # fmt: skip
    both = changes(State(stencil=Stencil(), stencil_back=Stencil(func="less")))
    assert {("stencil_back", None), ("stencil_back.func", "greater"), ("front_face", "cw")} <= both
    assert ("stencil", None) not in both  # the back's needs it
    boxed = State(viewport=(1, 2, 3, 4))
    (draw,) = mesh_pass("a.vert", "a.frag", Mesh(attributes={"aPos": [[0.0]]}),
                        target=Target(size=(8, 8)), state=boxed)  # fmt: skip
    made = Case(title="t", passes=[draw], expect=[exact("c", 1.0)])
    assert [m.new for m in mutate_state(made) if m.path == "viewport"] == [
        None, (2, 2, 3, 4), (1, 3, 3, 4), (1, 2, 4, 4), (1, 2, 3, 5),
    ]  # fmt: skip


def test_a_state_mutant_changes_its_own_draw_alone() -> None:
    case = case_of(State(depth=Depth()), draws=3)
    mutant = next(m for m in mutate_state(case) if m.before == "main[1] depth.func='less'")
    (scene,) = case.scenes()
    effect = mutant.effect(scene)
    assert effect is not None and effect.passes == {"main"}
    changed = effect.scene
    functions = [draw.state.depth and draw.state.depth.func for draw in changed.passes[0].draws]
    assert functions == ["less", mutant.new, "less"]
    assert mutant.after == repr(mutant.new)


def test_a_state_that_draws_share_is_mutated_in_all_of_them() -> None:
    (one,) = mesh_pass(
        "a.vert", "a.frag", Mesh(attributes={"aPos": [[0.0]]}), state=State(depth=Depth())
    )
    passes = (one, replace(one, name="again"))
    case = Case(title="t", passes=passes, expect=[exact("again.c", 1.0)])
    mutants = mutate_state(case)
    assert len({(m.path, str(m.new)) for m in mutants}) == len(mutants) == 4
    effect = mutants[0].effect(next(case.scenes()))
    assert effect is not None and effect.passes == {"main", "again"}
    assert mutants[0].before == "main[0] and 1 more depth=on"


def test_of_many_draws_alike_a_few_are_tried_and_the_seed_says_which() -> None:
    case = case_of(State(depth=Depth()), draws=40)
    some = [m.draws[0][1] for m in mutate_state(case, seed=1) if m.path == "depth.write"]
    assert len(some) == 4 and some == sorted(some)
    assert some == [m.draws[0][1] for m in mutate_state(case, seed=1) if m.path == "depth.write"]
    assert some != [m.draws[0][1] for m in mutate_state(case, seed=2) if m.path == "depth.write"]


@pytest.mark.parametrize("kind", ["faces", "layers"])
def test_passes_read_as_faces_or_layers_are_drawn_with_their_reader(kind: str) -> None:
    """Without them every mutant of the reader would end in an error, and count as killed."""
    plain = Draw(fragment="map.frag", domain={})
    maps = [Pass(name=f"map {k}", target=Target(), draws=(plain,)) for k in range(6)]
    outputs = [Output(f"{made.name}.FragColor") for made in maps]
    texture = CubeTexture(faces=outputs) if kind == "faces" else TextureArray(layers=outputs)
    draw = Draw(fragment="a.frag", domain={}, textures={"maps": texture})
    reader = Pass(name="reader", target=Target(), draws=(draw,))
    case = Case(title="Maps", passes=(*maps, reader), expect=[exact("reader.FragColor", 1.0)])
    scene = next(iter(case.scenes()))
    assert with_read_passes(scene, {"reader"}) == {p.name for p in scene.passes}
    assert with_readers(scene, {"map 3"}) == {"map 3", "reader"}
