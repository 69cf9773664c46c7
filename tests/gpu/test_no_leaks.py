"""No state leaks from one scene to the next: the catalogue gives the same in any order.

Everything that is judged is in a scene's `Frame`, and judging is a function of that alone. So cases
that have between them whatever the catalogue sets (states, targets, meshes, textures, buffers) and
asks are drawn and captured in one process, in a random order and in its reverse, each in a context
of its own, and the frames are compared byte for byte; a sample is judged in both orders besides. Of
any two scenes each is drawn after the other in one of the orders: state that one leaves behind for
good shows in the other, whichever they are.
"""

from __future__ import annotations

import gc
import hashlib
import random
import weakref
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab.analysis.self_check import SelfCheck
from shaderlab.compiler.sources import Source
from shaderlab.drivers.opengl import drawing
from shaderlab.drivers.opengl.backend import OpenGLSession
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.driver_answers import coverage
from shaderlab.engine.expectations.exact import exact
from shaderlab.engine.expectations.formula import formula
from shaderlab.engine.pictures import PictureWriter
from shaderlab.engine.record import RecordBuilder
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderlabError, UnsupportedError
from shaderlab.glslmath import vec4
from shaderlab.model.case import Case, Scene
from shaderlab.model.expectation import Expectation, Judgement
from shaderlab.model.frame import Array, Fragments, PassDraw, Timing
from shaderlab.model.mesh import Mesh
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record
from shaderlab.model.scene import Pass, Target, mesh_pass
from shaderlab.model.state import State
from tests.catalogue import shipped

SEED = 1
SAMPLE = ("blend-equation", "depth-not-cleared", "z-fighting")
SIDE = 24
NAMES = {
    "fragment",
    "vertex",
    "geometry",
    "tess_control",
    "tess_evaluation",
    "compute",
    "name",
    "path",
}
"""Fields whose words are the case's own, not the lab's."""


class Watched(SceneRunner):
    """A lab that keeps a hash of each scene's frame, and judges only what it is told to."""

    def __init__(self, judged: Sequence[str] = ()) -> None:
        super().__init__(RunOptions(modules=False))
        self.hashes: dict[tuple[str, str], dict[str, str]] = {}
        self._judged = judged

    def cuts_loops(self, sources: Iterable[Source]) -> bool:
        """No: drawing probes for loops without end belongs to judging."""
        return False

    def judge_all(
        self,
        evaluation: Evaluation,
        record: RecordBuilder,
        pictures: PictureWriter,
        check: SelfCheck | None = None,
    ) -> dict[int, UnsupportedError]:
        scene, frame = evaluation.scene, evaluation.frame
        unanswered = {}
        for index, expectation in enumerate(scene.expect):
            try:
                evaluation.gather(expectation)
            except UnsupportedError as error:
                unanswered[index] = error
        found = {each.name: getattr(frame, each.name) for each in fields(frame)}
        found["answers"] = [
            (type(need).__name__, answer)
            for need, answer in frame.answers.items()
            if not isinstance(answer, Timing)  # seconds differ
        ]
        self.hashes[scene.case.id, scene.variant] = {
            name: digest(value) for name, value in found.items()
        }
        if scene.case.id in self._judged:
            super().judge_all(evaluation, record, pictures, check)
        return unanswered


def digest(value: Any) -> str:
    """A hash of all that a value is made of."""
    found = hashlib.sha256()
    for part in parts(value):
        found.update(part)
    return found.hexdigest()


def parts(value: Any) -> Iterator[bytes | memoryview]:
    """All that a value is made of, as bytes, with the names of its parts."""
    if isinstance(value, np.ndarray):
        yield f"{value.dtype.str}{value.shape}".encode()
        yield np.ascontiguousarray(value).reshape(-1).view(np.uint8).data
    elif isinstance(value, Mapping):
        for key, one in value.items():
            yield repr(key).encode()
            yield from parts(one)
    elif is_dataclass(value):
        for each in fields(value):
            yield each.name.encode()
            yield from parts(getattr(value, each.name))
    elif isinstance(value, frozenset):
        yield from parts(sorted(value))
    elif isinstance(value, tuple | list):
        yield f"{type(value).__name__}{len(value)}".encode()
        for one in value:
            yield from parts(one)
    elif isinstance(value, int) and value > 0xFFFFFFFF:
        yield b"an address"  # a mapping's, another one each time
    elif isinstance(value, ShaderlabError):
        yield str(value).encode()
    else:
        assert value is None or isinstance(value, str | bytes | bool | int | float), type(value)
        yield repr(value).encode()


def scenes() -> list[Scene]:
    """One variant of each of some cases, in a random order: the sample, and of all others as few as
    have whatever any of them sets or asks. What is not judged is drawn small."""
    first = {case.id: next(case.scenes()) for case in shipped().values()}
    kinds = {case_id: set(find_kinds(scene)) for case_id, scene in first.items()}
    costs = {case_id: 2 + len(scene.passes) / 4 for case_id, scene in first.items()}
    chosen = list(SAMPLE)
    left = set[Any]().union(*kinds.values()).difference(*(kinds[id] for id in SAMPLE))
    while left:
        gains = {case_id: len(kinds[case_id] & left) / costs[case_id] for case_id in kinds}
        chosen.append(max(gains, key=gains.__getitem__))
        left -= kinds[chosen[-1]]
    found = [first[id] if id in SAMPLE else smaller(first[id]) for id in chosen]
    random.Random(SEED).shuffle(found)
    return found


def find_kinds(value: Any, owner: str = "") -> Iterator[tuple[str, Any]]:
    """All that a scene sets and asks: each field of its parts that is not as it is by default, with
    the word, or the kind of value, that it has there."""
    if isinstance(value, Scene):
        yield from find_kinds(value.passes)
        yield from (("expectation", type(expectation)) for expectation in value.expect)
    elif is_dataclass(value):
        for each in fields(value):
            one, name = getattr(value, each.name), f"{type(value).__name__}.{each.name}"
            if each.name in NAMES:
                yield name, bool(one)
            elif not isinstance(one, str | bool | int | float | None) or one != each.default:
                yield from find_kinds(one, name)
    elif isinstance(value, Mapping | tuple | list | frozenset):
        for one in value.values() if isinstance(value, Mapping) else value:
            yield from find_kinds(one, owner)
    elif isinstance(value, np.ndarray):
        yield owner, (value.dtype.kind, value.ndim)
    else:
        word = isinstance(value, str | bool) and "." not in str(value)  # no file
        yield owner, value if word else isinstance(value, float | int) or type(value)


def smaller(scene: Scene) -> Scene:
    """The scene in targets of at most SIDE pixels a side, each pass read by one expectation: the
    same kinds of calls in less time."""
    passes, expect, read = [], [], set[str]()
    for expectation in scene.expect:
        names = {each.pass_name for each in expectation.find_reads(scene)}
        if not (expect and names <= read):
            expect.append(expectation)
            read |= names
    for one in scene.passes:
        size = one.target.size
        small = size and (min(size[0], SIDE), min(size[1], SIDE))
        passes.append(replace(one, target=replace(one.target, size=small)))
    return replace(scene, passes=tuple(passes), expect=tuple(expect))


def shown(record: Record) -> list[Any]:
    """What a record says that is no time and no picture."""
    return [
        (record.id, record.status, record.message),
        *(replace(o, images={}, values={}) for o in record.expectations),
    ]


def test_an_order_and_its_reverse_draw_the_same() -> None:
    found, outcomes = [], []
    order = scenes()
    for each in (order, order[::-1]):
        with Watched(SAMPLE) as lab:
            records = [lab.run(scene) for scene in each]
        assert {r.status for r in records} <= {"pass", "unsupported"}, records
        found.append(lab.hashes)
        outcomes.append({r.id: shown(r) for r in records})
    one, other = found
    assert len(one) == len(order)
    apart = {key for key in one if other.get(key) != one[key]}
    assert apart == set(), f"{sorted(apart)} depend on what ran before"
    assert outcomes[0] == outcomes[1]


LEAKS = {
    "depth clamp": lambda gl: gl.glEnable(gl.GL_DEPTH_CLAMP),
    "lines for faces": lambda gl: gl.glPolygonMode(gl.GL_FRONT_AND_BACK, gl.GL_LINE),
    "inverted pixels": lambda gl: (gl.glEnable(gl.GL_COLOR_LOGIC_OP), gl.glLogicOp(gl.GL_INVERT)),
}
"""State that the lab has no word for and never touches."""

SHADERS = {
    "near.vert": "in vec3 aPos;\nvoid main() { gl_Position = vec4(aPos, 1.0); }\n",
    "near.frag": "out vec4 FragColor;\nvoid main() { FragColor = vec4(1.0, 0.5, 0.25, 1.0); }\n",
}


def triangle(folder: Path, name: str, state: State) -> Scene:
    """A triangle that leaves the view's depth range at one corner."""
    corners = np.array([(-0.9, -0.9, 0.0), (0.9, -0.9, 0.0), (0.0, 0.9, 3.0)], np.float32)
    for file, text in SHADERS.items():
        (folder / file).write_text("#version 330 core\n" + text)
    passes = mesh_pass(
        "near.vert", "near.frag", Mesh(attributes={"aPos": corners}), state=state,
        target=Target(colors={"FragColor": "rgba8"}),
    )  # fmt: skip
    case = Case(
        title=name, section="1", passes=passes, expect=[exact("FragColor", 0)],
        id=name, file=str(folder / f"{name}.py"),
    )  # fmt: skip
    return next(iter(case.scenes()))


def test_a_scene_is_gone_when_its_session_ends(tmp_path: Path) -> None:
    """Without waiting for cycles to be collected: its images may be large, and objects are few."""
    scene = triangle(tmp_path, "gone", State())
    gc.collect()
    gc.disable()
    try:
        with SceneRunner() as lab, lab.evaluation(scene, lab.prepare(scene)) as evaluation:
            key = next(iter(evaluation.session.programs)), 0
            assert evaluation.session.capture_fragments(key).covered.any()
            session = weakref.ref(evaluation.session)
        del evaluation
        assert session() is None
    finally:
        gc.enable()


def test_what_no_later_expectation_asks_for_is_let_go(tmp_path: Path) -> None:
    checks = coverage(1, name="once"), coverage(2, name="again"), exact("FragColor", 0)
    scene = replace(triangle(tmp_path, "kept", State()), expect=checks)
    left = {}

    class Looking(Evaluation):
        def judge(self, expectation: Expectation) -> Judgement:
            left[expectation.name] = len(self.answers)
            return super().judge(expectation)

    with SceneRunner() as lab, lab.evaluation(scene, lab.prepare(scene)) as evaluation:
        evaluation.__class__ = Looking
        lab.judge_all(evaluation, RecordBuilder(scene), PictureWriter(None, "kept", ""))
    assert list(left.values()) == [1, 1, 0]


def test_captures_are_held_for_one_pass_at_a_time_and_drawn_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a scene with many captures all would be held at once."""
    scene = triangle(tmp_path, "turns", State())
    (tmp_path / "near.frag").write_text(
        "#version 330 core\nout vec4 FragColor;\n"
        "void main() { if (gl_FragCoord.x < 0.0) discard; FragColor = vec4(1.0); }\n"
    )
    passes = tuple(replace(scene.passes[0], name=name) for name in "abc")
    checks = tuple(
        formula(f"{name}.FragColor", lambda: vec4(1.0, 1.0, 1.0, 1.0), name=f"{name}, {again}")
        for name in "abc"
        for again in ("once", "again")
    )
    held: list[weakref.ref[Any]] = []
    others, redraws = [], list[str]()

    def fragments(session: OpenGLSession, key: PassDraw) -> Fragments:
        others.append(sum(each() is not None for each in held))
        found = captured(session, key)
        held.append(weakref.ref(found.covered))
        return found

    def redrawn(session: OpenGLSession, description: Pass, *rest: Any) -> Mapping[str, Array]:
        redraws.append(description.name)
        return drawn(session, description, *rest)

    captured, drawn = OpenGLSession.capture_fragments, OpenGLSession.redraw_with_texts
    monkeypatch.setattr(OpenGLSession, "capture_fragments", fragments)
    monkeypatch.setattr(OpenGLSession, "redraw_with_texts", redrawn)
    with SceneRunner() as lab:
        record = lab.run(replace(scene, passes=passes, expect=checks))
    assert [o.status for o in record.expectations] == ["pass"] * 6, record.message
    assert record.modules is not None and record.modules.judged > 0
    assert others == [0, 0, 0] and redraws == [*"aabbcc"]


@pytest.mark.parametrize("leak", [None, *LEAKS])
def test_a_leak_is_caught(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, leak: str | None
) -> None:
    """The same comparison, with a lab that leaves something on after a case that culls."""
    right = drawing.apply_state

    def leaking(state: State, size: tuple[int, int], version: int) -> None:
        from OpenGL import GL  # only once a device is open, which chooses its platform

        right(state, size, version)
        if state.cull is not None and leak is not None:
            LEAKS[leak](GL)

    monkeypatch.setattr(drawing, "apply_state", leaking)
    culling, plain = (
        triangle(tmp_path, "culling", State(cull="front")),
        triangle(tmp_path, "plain", State()),
    )
    found = []
    for order in ((plain, culling), (culling, plain)):
        with Watched() as lab:
            records = [lab.run(scene) for scene in order]
            assert [r.status for r in records] == ["pass", "pass"], [r.message for r in records]
            found.append(lab.hashes["plain", "default"])
    assert (found[0] != found[1]) == (leak is not None)
