"""Fragments that shaders keep out: missing ones fail whatever judges the picture, unless a rule of
the case says that they are discarded; and a rule is held against what is seen."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Case,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    Ramp,
    State,
    Target,
    bounded,
    coverage,
    exact,
    formula,
    fullscreen,
    measure,
    value,
)
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.needs import CapturedFragments
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import length, swizzle
from shaderlab.model.expectation import Need
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Outcome

HEAD = "#version 330 core\nin vec2 at; out vec4 color;\n"
COLOR = "void main() { color = vec4(at, 0.0, 1.0);"
CHESS = " if (((int(gl_FragCoord.x) + int(gl_FragCoord.y)) & 1) == 1) discard;"
DISC = " if (length(at) > 0.75) discard;"
SQUARE = {"at": Ramp((-1.0, -1.0), (2.0, 0.0), (0.0, 2.0))}


def whole(at: Any) -> Any:
    from shaderlab.glslmath import vec4

    return vec4(at, 0.0, 1.0)


def outside(at: Any) -> Any:
    return length(at) > 0.75


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16)) as made:
        yield made


def outcomes(lab: SceneRunner, folder: Path, passes: Any, *expect: Any) -> list[Outcome]:
    made = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=expect)
    record = lab.run(made.scene("default"))
    assert record.expectations, record.message
    return list(record.expectations)


def written(folder: Path, text: str) -> str:
    """The name of a file with this text: a lab reads each name once."""
    name = f"{hashlib.sha256(text.encode()).hexdigest()[:8]}.frag"
    (folder / name).write_text(text)
    return name


def drawn(folder: Path, ending: str, **more: Any) -> tuple[Pass, ...]:
    return fullscreen(written(folder, HEAD + COLOR + ending + " }\n"), domain=SQUARE, **more)


def test_missing_fragments_fail_whatever_judges_the_picture(
    lab: SceneRunner, tmp_path: Path
) -> None:
    passes = (*drawn(tmp_path, CHESS + " ", name="one"), *drawn(tmp_path, CHESS, name="two"))
    found = outcomes(
        lab, tmp_path, passes,
        formula("two.color", whole),
        exact("two.color", Output("one.color")),
        measure("mean alpha", lambda color: color[..., 3].mean(), between=(0.0, 1.0)),
        bounded("two.color", 0.0, 1.0, over="at", values=[(0.1, 0.1)]),
        coverage(128),
    )  # fmt: skip
    assert [o.status for o in found] == ["fail"] * 4 + ["pass"]
    assert found[0].message.startswith(
        "missing: 128 fragments (the first at pixel 1, 0) of draw 0 of pass 'two' ("
    )
    assert "discards=" in found[0].message


def test_a_rule_says_what_is_discarded(lab: SceneRunner, tmp_path: Path) -> None:
    (good,) = outcomes(
        lab, tmp_path, drawn(tmp_path, DISC), formula("color", whole, discards=outside)
    )
    assert good.status == "pass" and 0 < good.judged < 4 * 256


@pytest.mark.parametrize(
    ("ending", "word"),
    [
        (DISC.replace("0.75", "0.7"), "missing"),
        (DISC.replace("0.75", "0.8"), "surplus"),
        (DISC.replace(">", "<"), "missing"),
        (DISC + CHESS, "missing"),
        (DISC.replace("discard", "color.x = at.x"), "surplus"),
    ],
)
def test_a_shader_that_discards_other_fragments_is_caught(
    lab: SceneRunner, tmp_path: Path, ending: str, word: str
) -> None:
    passes = drawn(tmp_path, ending)
    (found,) = outcomes(lab, tmp_path, passes, formula("color", whole, discards=outside))
    assert found.status == "fail" and found.message.startswith(word), found.message


def test_fragments_whose_rule_is_undecided_may_be_either(lab: SceneRunner, tmp_path: Path) -> None:
    def unsure(at: Any) -> Any:
        from shaderlab.glslmath import sin

        return sin(swizzle(at, "x") * 1e4) > 0.0  # out of sin's range: anything

    for ending in ("", CHESS, " discard;"):
        passes = drawn(tmp_path, ending)
        (found,) = outcomes(
            lab, tmp_path, passes,
            measure("any", lambda color: color.max(), at_least=0.0),
        )  # fmt: skip
        assert (found.status == "fail") == bool(ending)
        found, _ = outcomes(
            lab, tmp_path, passes,
            measure("any", lambda color: color.max(), at_least=0.0),
            formula("color", whole, discards=unsure),
        )  # fmt: skip
        assert found.status == "pass", found.message


def test_the_rule_of_a_shader_holds_for_all_its_draws(lab: SceneRunner, tmp_path: Path) -> None:
    passes = (*drawn(tmp_path, DISC, name="one"), *drawn(tmp_path, DISC, name="two"))
    cut = formula("one.color", whole, discards=outside)
    assert [
        o.status for o in outcomes(lab, tmp_path, passes, cut, formula("two.color", whole))
    ] == ["pass", "pass"]
    alone = outcomes(lab, tmp_path, passes, formula("two.color", whole))
    assert alone[0].status == "fail"


def quads(*depths: float) -> Mesh:
    """Quads over the whole target, one behind the other."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]], np.float32)
    places = [np.column_stack([corners, np.full(6, z, np.float32)]) for z in depths]
    return Mesh(attributes={"aPos": np.concatenate(places)})


VERTEX = "#version 330 core\nin vec3 aPos; void main() { gl_Position = vec4(aPos, 1.0); }\n"


def behind(folder: Path, text: str, *, depths: tuple[float, ...] = (-0.5, 0.5)) -> tuple[Pass, ...]:
    (folder / "a.vert").write_text(VERTEX)
    fragment = written(folder, "#version 330 core\nout float z;\n" + text)
    draw = Draw(vertex="a.vert", fragment=fragment, mesh=quads(*depths), state=State(depth=Depth()))
    return (Pass(name="main", target=Target(depth="depth32f"), draws=(draw,)),)


def test_what_shines_through_a_hole_does_not_hide_it(lab: SceneRunner, tmp_path: Path) -> None:
    """The farther quad covers the pixels where the nearer one is kept out, and is right there."""

    def depth(frag_coord: Any) -> Any:
        return swizzle(frag_coord, "z")

    def nearer(frag_coord: Any) -> Any:
        return swizzle(frag_coord, "z") < 0.5

    hole = "void main() { z = gl_FragCoord.z; if (z < 0.5) discard; }\n"
    (found,) = outcomes(lab, tmp_path, behind(tmp_path, hole), formula("z", depth))
    assert found.status == "fail" and found.message.startswith("missing: 256 fragments")
    (right,) = outcomes(lab, tmp_path, behind(tmp_path, hole), formula("z", depth, discards=nearer))
    assert right.status == "pass"


def test_a_depth_that_is_written_may_change_the_order_but_not_leave_holes(
    lab: SceneRunner, tmp_path: Path
) -> None:
    def turned(frag_coord: Any) -> Any:
        return 1.0 - swizzle(frag_coord, "z")

    text = "void main() { z = 1.0 - gl_FragCoord.z; gl_FragDepth = z; }\n"
    (right,) = outcomes(lab, tmp_path, behind(tmp_path, text), formula("z", turned))
    assert right.status == "pass"
    chess = "if (((int(gl_FragCoord.x) + int(gl_FragCoord.y)) & 1) == 1) gl_FragDepth = 1.0; }"
    (wrong,) = outcomes(
        lab, tmp_path, behind(tmp_path, text.replace("}", chess)), formula("z", turned)
    )
    assert wrong.status == "fail" and wrong.message.startswith("missing: 128 fragments")


def test_samples_that_are_discarded_have_no_value(lab: SceneRunner, tmp_path: Path) -> None:
    passes = drawn(tmp_path, DISC)
    places = [(0.0, 0.0), (1.0, 1.0)]
    found = outcomes(
        lab, tmp_path, passes,
        bounded("color", 0.0, 1.0, over="at", values=places, discards=outside),
        bounded("color", 0.0, 1.0, over="at", values=places[:1]),
        value("color", at={"at": (1.0, 1.0)}, equals=(0.0,) * 4, digits=1),
    )  # fmt: skip
    assert [o.status for o in found] == ["fail", "pass", "fail"]
    assert "discards 1 of the samples" in found[0].message


def test_a_rule_is_a_comparison(lab: SceneRunner, tmp_path: Path) -> None:
    for rule in (length, lambda at: length(at), lambda at: at > 0.5):
        made = Case(
            title="t", id="t", file=str(tmp_path / "t.py"),
            passes=drawn(tmp_path, DISC), expect=[formula("color", whole, discards=rule)],
        )  # fmt: skip
        record = lab.run(made.scene("default"))
        assert record.status == "error", record


def test_what_draws_discard_is_examined_one_after_the_other(
    lab: SceneRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Captures of all draws of a large pass do not fit into memory together."""
    kept: list[int] = []
    forget = Evaluation.forget

    def count(self: Evaluation, needs: Iterable[Need]) -> None:
        kept.append(sum(isinstance(need, CapturedFragments) for need in self.answers))
        forget(self, needs)

    monkeypatch.setattr(Evaluation, "forget", count)
    (scene,) = drawn(tmp_path, DISC)
    passes = [replace(scene, draws=scene.draws * 4)]
    mean = measure("mean", lambda color: color[..., 3].mean(), between=(0.0, 1.0))
    rule = formula("color", whole, draw=3, discards=outside)
    found = outcomes(lab, tmp_path, passes, mean, rule)
    assert kept and max(kept) <= 1, [o.message for o in found]
