"""State of a draw: rectangles, depth range, offsets, points, stencil by face, samples; no leaks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Blend,
    Case,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    Pixel,
    State,
    Stencil,
    Target,
    coverage,
    exact,
    formula,
    measure,
    value,
)
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError
from shaderlab.glslmath import swizzle
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

PLACED = """#version 330 core
in vec3 aPos;
uniform float size;
out vec3 Ndc;
void main() { Ndc = aPos; gl_PointSize = size; gl_Position = vec4(aPos, 1.0); }
"""
SEEN = """#version 330 core
in vec3 Ndc;
uniform float tone;
out float shown; out vec3 place;
void main() { shown = tone + 0.0 * Ndc.x; place = gl_FragCoord.xyz; }
"""
CORNERS = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
COUNTER_CLOCKWISE, CLOCKWISE = (0, 1, 2, 0, 2, 3), (0, 2, 1, 0, 3, 2)


def square(depth: float = 0.0, order: tuple[int, ...] = COUNTER_CLOCKWISE) -> Mesh:
    corners = np.array([(x, y, depth) for x, y in CORNERS], np.float32)
    return Mesh(attributes={"aPos": corners}, indices=np.array(order))


def point(x: float, y: float) -> Mesh:
    return Mesh(attributes={"aPos": np.array([(x, y, 0.0)])}, primitive="points")


def draw(mesh: Mesh, tone: float = 1.0, size: float = 1.0, **state: Any) -> Draw:
    return Draw(
        vertex="placed.vert",
        fragment="seen.frag",
        mesh=mesh,
        uniforms={"tone": tone, "size": size},
        state=State(**state),
    )


def into(*draws: Draw, depth: str | None = None, **target: Any) -> tuple[Pass, ...]:
    return (Pass(target=Target(size=(16, 8), depth=depth, **target), draws=draws),)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("shaders")
    (made / "placed.vert").write_text(PLACED)
    (made / "seen.frag").write_text(SEEN)
    return made


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16)) as made:
        yield made


def run(lab: SceneRunner, folder: Path, passes: Any, *expect: Any) -> Record:
    made = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=expect)
    return lab.run(made.scene("default"))


def filled(x: int, y: int, width: int, height: int) -> Any:
    """16 × 8 pixels, 1 in the rectangle and 0 elsewhere."""
    image = np.zeros((8, 16, 1), np.float32)
    image[y : y + height, x : x + width] = 1.0
    return image


def placed(Ndc: Any, frag_coord: Any) -> Any:
    """Where a fragment of the viewport (4, 2, 8, 4) with the depth range ¼ … ¾ must be."""
    return swizzle(Ndc, "xyz") * np.array([4.0, 2.0, 0.25]) + np.array([8.0, 4.0, 0.5])


def test_a_viewport_maps_and_a_scissor_cuts(lab: SceneRunner, folder: Path) -> None:
    viewport = into(draw(square(), viewport=(4, 2, 8, 4)))
    record = run(lab, folder, viewport, exact("shown", filled(4, 2, 8, 4)), coverage(32))
    assert record.status == "pass", record
    scissor = into(draw(square(), viewport=(4, 2, 8, 4), scissor=(6, 0, 4, 3)))
    record = run(lab, folder, scissor, exact("shown", filled(6, 2, 4, 1)), coverage(4))
    assert record.status == "pass", record
    wrong = into(draw(square(), viewport=(5, 2, 8, 4)))
    assert run(lab, folder, wrong, exact("shown", filled(4, 2, 8, 4))).status == "fail"


def test_capture_sees_the_viewport_and_the_depth_range(lab: SceneRunner, folder: Path) -> None:
    state = {"viewport": (4, 2, 8, 4), "depth_range": (0.25, 0.75)}
    passes = into(draw(square(0.5), **state))
    at = value("place", at=Pixel(4, 2), equals=(4.5, 2.5, 0.625), digits=6)
    assert run(lab, folder, passes, formula("place", placed), at).status == "pass"
    other = into(draw(square(0.5), **state | {"depth_range": (0.75, 0.25)}))
    assert run(lab, folder, other, formula("place", placed)).status == "fail"


def test_the_depth_range_decides_a_depth_test(lab: SceneRunner, folder: Path) -> None:
    near = draw(square(0.9), 1.0, depth=Depth(), depth_range=(0.0, 0.1))
    far = draw(square(-0.9), 2.0, depth=Depth(), depth_range=(0.9, 1.0))
    for order in ((near, far), (far, near)):
        record = run(lab, folder, into(*order, depth="depth24"), exact("shown", 1.0))
        assert record.status == "pass", record


def test_polygon_offset_moves_what_is_tested(lab: SceneRunner, folder: Path) -> None:
    first = draw(square(), 1.0, depth=Depth())
    for offset, winner in ((None, 1.0), ((0.0, -1.0), 2.0), ((0.0, 1.0), 1.0)):
        again = draw(square(), 2.0, depth=Depth(), polygon_offset=offset)
        passes = into(first, again, depth="depth24")
        assert run(lab, folder, passes, exact("shown", winner)).status == "pass", offset
    # The factor counts only where a triangle slopes.
    slope = Mesh(
        attributes={"aPos": np.array([(x, y, 0.5 * x) for x, y in CORNERS])},
        indices=np.array(COUNTER_CLOCKWISE),
    )
    for mesh, winner in ((square(), 1.0), (slope, 2.0)):
        again = draw(mesh, 2.0, depth=Depth(), polygon_offset=(-1.0, 0.0))
        passes = into(draw(mesh, 1.0, depth=Depth()), again, depth="depth24")
        assert run(lab, folder, passes, exact("shown", winner)).status == "pass", winner


def test_points_are_as_large_as_the_state_or_the_shader_says(
    lab: SceneRunner, folder: Path
) -> None:
    for given, size, count in ((4.0, 2.0, 16), ("program", 2.0, 4), (None, 2.0, 4), (1.0, 6.0, 1)):
        made = draw(point(0.0, 0.0) if count > 1 else point(1 / 16, 1 / 8), 1.0, size)
        made = replace(made, state=State(point_size=given))
        record = run(lab, folder, into(made), coverage(count))
        assert record.status == "pass", record


def test_faces_have_a_stencil_test_each(lab: SceneRunner, folder: Path) -> None:
    front = Stencil(reference=3, depth_pass="replace")
    back = Stencil(reference=5, depth_pass="replace")
    for order, stored in ((COUNTER_CLOCKWISE, 3), (CLOCKWISE, 5)):
        mark = draw(square(0.0, order), stencil=front, stencil_back=back)
        show = draw(square(), 2.0, stencil=Stencil(func="equal", reference=stored))
        passes = into(mark, show, depth="depth24_stencil8")
        record = run(lab, folder, passes, exact("shown", 2.0))
        assert record.status == "pass", record
    one_for_both = draw(square(0.0, CLOCKWISE), stencil=front)
    show = draw(square(), 2.0, stencil=Stencil(func="equal", reference=3))
    passes = into(one_for_both, show, depth="depth24_stencil8")
    assert run(lab, folder, passes, exact("shown", 2.0)).status == "pass"


ODD = State(
    depth=Depth(func="greater", write=False),
    stencil=Stencil(func="never", write_mask=0),
    stencil_back=Stencil(func="never", reference=7, write_mask=1, fail="invert"),
    blend=Blend(source="zero", destination="constant_color", constant=(0.1, 0.2, 0.3, 0.4)),
    cull="front_and_back",
    front_face="cw",
    color_mask=(False, True, False, True),
    srgb=True,
    viewport=(1, 1, 2, 2),
    scissor=(1, 1, 1, 1),
    depth_range=(0.9, 0.1),
    polygon_offset=(3.0, 5.0),
    point_size=7.0,
    multisample=False,
    alpha_to_coverage=True,
)


@pytest.mark.parametrize("mesh", [square(0.25), point(0.03125, 0.0625)], ids=["square", "point"])
@pytest.mark.parametrize("size", ["program", 7.0])
def test_no_state_of_one_draw_reaches_the_next(
    lab: SceneRunner, folder: Path, mesh: Any, size: Any
) -> None:
    odd = replace(ODD, point_size=size)
    target = {"depth": "depth24_stencil8"}
    single = {"point_size": 1.0}
    test = {"depth": Depth(), "stencil": Stencil(depth_pass="incr"), "cull": "back"}
    last = draw(mesh, 0.5, 3.0, **test, **single)
    plain = draw(mesh, 3.0, 3.0, **single)
    show = draw(square(-0.5), 2.0, stencil=Stencil(func="equal", reference=1))
    count = 128 if mesh.primitive == "triangles" else 1
    for end, tone in ((show, 2.0), (plain, 3.0)):
        alone = into(last, end, **target)
        after = into(replace(draw(square(), 9.0), state=odd), last, end, **target)
        picture = tone if count == 128 else [[0.0] * 16] * 4 + [[0.0] * 8 + [tone] + [0.0] * 7]
        picture = picture if count == 128 else np.array([*picture, *[[0.0] * 16] * 3])
        for passes in (alone, after):
            checks = (coverage(count), coverage(0, draw=-2), exact("shown", picture))
            record = run(lab, folder, passes, *checks)
            assert record.status == "pass", record


def test_no_state_of_one_draw_reaches_the_next_scene(lab: SceneRunner, folder: Path) -> None:
    depth = into(draw(square(0.5), depth=Depth()), depth="depth24")
    expected = [exact("shown", 1.0), value("place", at=Pixel(0, 0), equals=(0.5, 0.5, 0.75),
                digits=6)]  # fmt: skip
    assert run(lab, folder, depth, *expected).status == "pass"
    odd = into(replace(draw(square()), state=ODD), depth="depth24_stencil8")
    assert run(lab, folder, odd, exact("shown", 0.0)).status == "pass"
    assert run(lab, folder, depth, *expected).status == "pass"


def test_a_reference_may_ask_where_samples_are(lab: SceneRunner, folder: Path) -> None:
    if int(lab.backend.info["max_samples"]) < 4:
        pytest.skip("this driver has one sample a pixel")
    seen: dict[str, Any] = {}

    def at_samples(tone: Any, sample_positions: Any, main_sample_positions: Any) -> Any:
        seen["own"], seen["main"] = sample_positions, main_sample_positions
        return tone

    passes = into(draw(square()), samples=4)
    record = run(lab, folder, passes, formula("shown", at_samples))
    assert record.status == "pass", record
    positions = [[float(np.ravel(p.lo if hasattr(p, "lo") else p)[k]) for k in (0, 1)]
                 for p in seen["own"]]  # fmt: skip
    assert len(seen["main"]) == len(positions) == 4
    assert all(0.0 < v < 1.0 for p in positions for v in p)
    assert len({tuple(p) for p in positions}) == 4
    # A pass of one sample a pixel has no such input.
    record = run(lab, folder, into(draw(square())), formula("shown", at_samples))
    assert "'sample_positions'" in record.expectations[0].message


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: State(stencil_back=Stencil()), "without stencil"),
        (lambda: State(viewport=(0, 0, -1, 4)), "viewport"),
        (lambda: State(scissor=(0, 0, 4)), "scissor"),
        (lambda: State(viewport=(0.5, 0, 4, 4)), "viewport"),
        (lambda: State(depth_range=(0.0, 1.5)), "depth_range"),
        (lambda: State(polygon_offset=(float("nan"), 0.0)), "polygon_offset"),
        (lambda: State(point_size=0.0), "point_size"),
        (lambda: State(point_size="programme"), "point_size"),
        (lambda: State(sample_shading=2.0), "sample_shading"),
        (lambda: Pass(draws=(draw(square(), viewport=(0, 0, 4, 4)),)), "target has no size"),
    ],
)
def test_wrong_state_is_refused_where_it_is_written(make: Any, says: str) -> None:
    with pytest.raises(CaseError, match=says):
        make()


def test_a_measure_may_read_the_depth_of_any_pass(lab: SceneRunner, folder: Path) -> None:
    def mean(depth: Any) -> Any:
        return depth.mean()

    state = {"depth": Depth(), "depth_range": (0.25, 0.75)}
    target = Target(size=(16, 8), depth="depth24")
    passes = (
        Pass(name="first", target=target, draws=(draw(square(0.5), **state),)),
        Pass(name="last", target=Target(size=(16, 8)), draws=(draw(square()),)),
    )
    right = measure("depth", mean, reads={"depth": "first.depth"}, equals=0.625, digits=6)
    assert run(lab, folder, passes, right).status == "pass"
    wrong = measure("depth", mean, reads={"depth": "first.depth"}, equals=0.75, digits=6)
    assert run(lab, folder, passes, wrong).status == "fail"


def test_an_output_that_another_is_compared_with_is_judged_as_well(folder: Path) -> None:
    passes = tuple(
        Pass(name=name, target=Target(size=(16, 8)), draws=(draw(square()),))
        for name in ("one", "other", "third")
    )
    same = exact("one.shown", Output("other.shown"))
    scene = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=[same]).scene(
        "default"
    )
    assert same.passes(scene) == {"one", "other"}
