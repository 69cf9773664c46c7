"""Fragments that are captured once for all draws that must get the same, and for no others."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import Case, Draw, Mesh, Pass, Ramp, State, Target, across, formula, mesh_pass
from shaderlab.drivers.opengl.backend import OpenGLBackend
from shaderlab.drivers.programs.fragment_capture import CaptureCache
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.formula import Formula
from shaderlab.engine.expectations.needs import CapturedFragments
from shaderlab.engine.lab import Lab
from shaderlab.errors import UnsupportedError
from shaderlab.model.case import Scene
from shaderlab.model.frame import Fragments, PassDraw
from shaderlab.model.options import RunOptions
from shaderlab.model.state import Blend, Cell, Depth
from tests.catalogue import shipped

SHADER = """#version 330 core
{declared}
out vec4 FragColor;
void main() {{ FragColor = vec4({body}); }}
"""


class Counting(CaptureCache):
    """CaptureCache that write down what was asked for, and what was there."""

    def __init__(self, room: int = 1 << 25) -> None:
        super().__init__(room)
        self.asked: list[Hashable | None] = []
        self.made = 0

    def get(self, identity: Hashable | None, capture: Callable[[], Fragments]) -> Fragments:
        self.asked.append(identity)

        def counted() -> Fragments:
            self.made += 1
            return capture()

        return super().get(identity, counted)


class Watched(Lab):
    """A lab that keeps what was captured for each scene, and judges nothing."""

    def __init__(self, room: int = 1 << 25) -> None:
        super().__init__(RunOptions(size=32))
        assert isinstance(self.backend, OpenGLBackend)
        self.captures = self.backend.captures = Counting(room)
        self.seen: dict[tuple[str, str], Mapping[PassDraw, Fragments]] = {}

    def judge_all(self, evaluation: Evaluation, *_: Any) -> dict[int, UnsupportedError]:
        scene = evaluation.scene
        for expectation in scene.expect:
            evaluation.gather(expectation)
        self.seen[scene.case.id, scene.variant] = {
            need.key: answer
            for need, answer in evaluation.answers.items()
            if isinstance(need, CapturedFragments)
        }
        return {}


@pytest.fixture
def lab() -> Iterator[Watched]:
    with Watched() as made:
        yield made


def scene(folder: Path, name: str, passes: tuple[Pass, ...]) -> Scene:
    return Case(
        title=name, id=name, file=str(folder / "t.py"), passes=passes,
        expect=[formula("FragColor", lambda: 0.0)],
    ).scene("default")  # fmt: skip


def light(
    folder: Path,
    name: str,
    *,
    body: str = "x, x, x, 1.0",
    declared: str = "in float x;",
    ramp: Ramp | None = None,
    state: State | None = None,
    target: Target | None = None,
    draws: int = 1,
) -> Scene:
    """A program of its own over a domain."""
    (folder / f"{name}.frag").write_text(SHADER.format(body=body, declared=declared))
    draw = Draw(
        fragment=f"{name}.frag", domain={"x": ramp or across(0.0, 1.0)}, state=state or State()
    )
    only = Pass(name="main", target=target or Target(), draws=(draw,) * draws)
    return scene(folder, name, (only,))


def captured(lab: Watched, one: Scene) -> Fragments:
    record = lab.run(one)
    assert record.status != "error", record.message
    (found,) = lab.seen[one.case.id, one.variant].values()
    return found


def test_another_shader_over_the_same_domain_gets_the_same(lab: Watched, tmp_path: Path) -> None:
    first = captured(lab, light(tmp_path, "first"))
    second = captured(lab, light(tmp_path, "second", body="x * x, 0.0, 1.0 - x, 1.0"))
    assert lab.captures.made == 1 and second is first
    np.testing.assert_array_equal(first.inputs["x"][0, :, 0], (np.arange(32) + 0.5) / 32)


def test_what_is_captured_holds_no_more_than_it_is(lab: Watched, tmp_path: Path) -> None:
    """Attachments have more components than some inputs; what is kept is counted by its own."""
    ramp = Ramp((0.0, 0.0), dx=(1.0, 0.0), dy=(0.0, 1.0))
    one = light(tmp_path, "one", declared="in vec2 x;", body="x, 0.0, 1.0", ramp=ramp)
    values = captured(lab, one).inputs["x"]
    assert values.shape == (32, 32, 2) and values.base is None and values.flags.c_contiguous
    np.testing.assert_array_equal(values[3, 5], np.array([5.5, 3.5]) / 32)


OTHERS: dict[str, dict[str, Any]] = {
    "another ramp": {"ramp": across(0.0, 2.0)},
    "another type": {"declared": "flat in float x;"},
    "another size": {"target": Target(size=(32, 16))},
    "a part of the target": {"state": State(cell=Cell(column=0, row=0, columns=2, rows=2))},
    "another range of depth": {"state": State(depth_range=(0.25, 0.75))},
    "an input of the driver's": {"body": "x, float(gl_FrontFacing), 0.0, 1.0"},
}
UNTOLD: dict[str, dict[str, Any]] = {
    "discard": {"body": "x, 0.0, 0.0, 1.0); if (x > 0.5) discard; FragColor += vec4(0.0"},
    "own depth": {"body": "x, 0.0, 0.0, 1.0); gl_FragDepth = x; FragColor += vec4(0.0"},
    "counted from the top": {"declared": "layout(origin_upper_left) in vec4 gl_FragCoord;"
                             "\nin float x;", "body": "x, gl_FragCoord.y, 0.0, 1.0"},
    "less precision": {"declared": "in mediump float x;"},
    "a depth test": {"state": State(depth=Depth()), "target": Target(depth="depth24")},
    "two draws": {"draws": 2},
    "many outputs": {"declared": "in float x;\n" + "".join(f"out float o{k};" for k in range(6)),
                     "body": "x); " + "".join(f"o{k} = x; " for k in range(6))
                     + "FragColor += vec4(0.0"},
}  # fmt: skip


@pytest.mark.parametrize("change", [*OTHERS, *UNTOLD])
def test_what_may_get_something_else_is_captured_itself(
    lab: Watched, tmp_path: Path, change: str
) -> None:
    captured(lab, light(tmp_path, "first"))
    lab.run(light(tmp_path, "other", **{**OTHERS, **UNTOLD}[change]))
    first, other = lab.captures.asked[0], lab.captures.asked[-1]
    assert lab.captures.made == 2 and other != first
    assert (other is None) == (change in UNTOLD)


def test_a_mesh_is_captured_itself(lab: Watched, tmp_path: Path) -> None:
    corners = np.array([[-1, -1, 0], [3, -1, 0], [-1, 3, 0]], np.float32)
    (tmp_path / "m.vert").write_text(
        "#version 330 core\nin vec3 aPos; out float x; uniform float k;\n"
        "void main() { x = aPos.x * k; gl_Position = vec4(aPos, 1.0); }\n"
    )
    (tmp_path / "m.frag").write_text(SHADER.format(declared="in float x;", body="x"))
    for k in (1.0, 2.0):
        passes = mesh_pass(
            "m.vert", "m.frag", Mesh(attributes={"aPos": corners}), uniforms={"k": k}
        )
        found = captured(lab, scene(tmp_path, f"mesh-{k}", passes))
        assert found.inputs["x"][0, -1, 0] == pytest.approx(k * (1 - 1 / 32))
    assert lab.captures.asked == [None, None]


def test_blending_and_masks_change_nothing(lab: Watched, tmp_path: Path) -> None:
    plain = captured(lab, light(tmp_path, "plain"))
    state = State(blend=Blend(), color_mask=(True, False, False, True))
    assert captured(lab, light(tmp_path, "blended", state=state)) is plain


def test_what_is_kept_can_not_be_written_to(lab: Watched, tmp_path: Path) -> None:
    found = captured(lab, light(tmp_path, "first"))
    for array in (found.covered, found.frag_coord, found.inputs["x"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_the_least_recently_used_goes_when_there_is_no_room() -> None:
    def some() -> Fragments:
        return Fragments(
            covered=np.ones((2, 2), bool), frag_coord=np.zeros((2, 2, 4), np.float32), inputs={}
        )

    kept = Counting(room=2 * (4 + 64))
    for name, made in [("a", 1), ("b", 2), ("a", 2), ("c", 3), ("a", 3), ("b", 4), ("c", 5)]:
        kept.get(name, some)
        assert kept.made == made, name
    kept.get("large", lambda: replace(some(), inputs={"x": np.zeros(99)}))
    kept.get("c", some)
    assert kept.made == 6  # what never fits drives nobody out
    nothing = Counting(room=10)
    assert [nothing.get("a", some) is not None for _ in range(2)] and nothing.made == 2


def fragments_only(one: Scene) -> Scene:
    """The scene with its formulas alone: they have fragments captured."""
    return replace(one, expect=tuple(e for e in one.expect if isinstance(e, Formula)))


def test_the_catalogue_gets_what_it_would_get_by_itself() -> None:
    """Scenes over a domain, with and without what others before them captured. Every other case
    of the catalogue: what is shared goes by the domain, and many have the same."""
    over = [
        fragments_only(one)
        for one in (next(iter(case.scenes())) for case in shipped().values())
        if all(draw.domain is not None for each in one.passes for draw in each.draws)
    ][::2]
    may_share = []
    with Watched() as sharing:
        for one in over:
            asked = len(sharing.captures.asked)
            assert sharing.run(one).status in ("pass", "unsupported")
            if any(identity is not None for identity in sharing.captures.asked[asked:]):
                may_share.append(one)
    with Watched(room=0) as alone:
        for one in may_share:
            assert alone.run(one).status in ("pass", "unsupported")
    assert alone.captures.made == len(alone.captures.asked)
    assert sharing.captures.made < len(sharing.captures.asked)  # it does happen
    assert len(alone.seen) == len(may_share) > 9
    for key, fragments in alone.seen.items():
        for draw, found in fragments.items():
            shared = sharing.seen[key][draw]
            np.testing.assert_array_equal(shared.covered, found.covered)
            np.testing.assert_array_equal(shared.frag_coord, found.frag_coord)
            assert shared.inputs.keys() == found.inputs.keys()
            for name, values in found.inputs.items():
                assert values.tobytes() == shared.inputs[name].tobytes(), (key, name)
