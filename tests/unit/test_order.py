"""The same scene in the opposite order, and what is compared."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from shaderlab.engine.expectations.any_order import Backwards, Redraw, any_order, both_ways
from shaderlab.engine.expectations.base import Context
from shaderlab.engine.expectations.exact import Exact
from shaderlab.model.case import Case
from shaderlab.model.frame import Image
from shaderlab.model.mesh import Mesh
from shaderlab.model.scene import Draw, Pass, Target
from shaderlab.model.state import Depth, State
from shaderlab.model.textures import Output


def draw(name: str, indices: list[int] | None = None, primitive: str = "triangles") -> Draw:
    mesh = Mesh(
        attributes={"aPos": np.zeros((6, 3))},
        indices=None if indices is None else np.array(indices),
        primitive=primitive,
    )
    return Draw(vertex=name, fragment="a.frag", mesh=mesh)


def backwards(*draws: Draw) -> Pass:
    first, second = both_ways(Pass(name="scene", target=Target(), draws=draws))
    assert (first.name, second.name, second.draws) == ("scene-backwards", "scene", draws)
    return first


def test_several_draws_change_places_and_stay_as_they_are() -> None:
    one, two = draw("1.vert", [0, 1, 2, 3, 4, 5]), draw("2.vert")
    assert backwards(one, two).draws == (two, one)


def test_of_one_draw_the_triangles_change_places_each_with_its_own_winding() -> None:
    (only,) = backwards(draw("1.vert", [0, 1, 2, 3, 4, 5])).draws
    assert only.mesh is not None and only.mesh.indices is not None
    assert only.mesh.indices.tolist() == [3, 4, 5, 0, 1, 2]
    strip = draw("1.vert", [0, 1, 2, 3], primitive="triangle_strip")
    assert backwards(strip).draws == (strip,)


def test_what_is_compared() -> None:
    check = any_order("scene.FragColor")
    assert isinstance(check, Exact) and check.output == "scene.FragColor"
    assert check.equals == Output("scene-backwards.FragColor")


def test_a_pass_is_drawn_anew_unless_its_own_depth_tests_show_the_nearest_surface() -> None:
    def drawn(*tests: str, cull: str | None = None) -> int:
        draws = [
            replace(draw(f"{i}.vert"), state=State(depth=Depth(func=t), cull=cull))
            for i, t in enumerate(tests)
        ]
        target = Target(depth="depth24")
        case = Case(
            title="two",
            passes=both_ways(Pass(name="scene", target=target, draws=draws)),
            expect=[any_order("scene.color")],
        )
        needs = case.scene("default").expect[0].needs(case.scene("default"), {})
        return len({need for need in needs if isinstance(need, Redraw)})

    assert drawn("less", "less") == drawn("lequal", "lequal") == 0
    assert drawn("less", "less", cull="back") == 3
    assert drawn("less", "lequal") == drawn("less", "always") == drawn("greater", "greater") == 6


class Shown:
    """What a device shows of two passes."""

    def __init__(
        self, samples: int = 0, alike: np.ndarray | None = None, **attachments: np.ndarray
    ) -> None:
        target = Target(depth="depth24", samples=samples)
        passes = both_ways(Pass(name="scene", target=target, draws=(draw("a.vert"),)))
        self._alike = alike
        if alike is not None:
            fewer = replace(target, colors={"color": "r32f"})
            passes = replace(passes[0], target=fewer), passes[1]
        case = Case(title="two", passes=passes, expect=[any_order("scene.color")])
        self.scene = case.scene("default")
        self._attachments = attachments

    def query(self, question: str, pass_name: str, name: str) -> Image:
        assert question == "attachment"
        which = name + ("_backwards" if "backwards" in pass_name else "")
        return Image(self._attachments[which], "r32f")

    def redraw_pass(self, changed: Pass, output: str, largest: int) -> np.ndarray:
        assert (changed.name, output) == ("scene", "color") and self._alike is not None
        assert changed.target.colors == {"color": "r32f"} and largest >= max(self._alike.shape)
        return self._alike


def apart(
    colors: np.ndarray,
    depths: float = 0.0,
    samples: int = 0,
    none: np.ndarray | None = None,
    alike: np.ndarray | None = None,
) -> int:
    """How many pixels any_order finds where black is drawn one way and `colors` the other."""
    none = np.zeros_like(colors) if none is None else none
    session: Any = Shown(
        samples,
        alike,
        color=none,
        color_backwards=colors,
        depth=none,
        depth_backwards=none + depths,
    )
    context = Context(session, {}, cast("Any", None), cast("Any", None))
    wanted = Backwards("scene", "color").answer(context)
    return int((wanted != none).any(axis=-1).sum())


def test_pixels_on_an_edge_may_show_either_face_and_areas_may_not() -> None:
    colors = np.zeros((5, 5, 1), np.float32)
    colors[:, 2], colors[0, 0] = 1.0, 1.0
    assert apart(colors) == 0
    assert apart(colors, depths=0.5) == 6 and apart(colors, samples=4) == 6
    colors[3:, 3] = 1.0  # beside the column, two of them make a square
    assert apart(colors) == 4


@pytest.mark.parametrize(("own", "other"), [(3, 4), (4, 3), (1, 4)])
def test_a_component_that_one_pass_alone_has_is_not_compared(own: int, other: int) -> None:
    black, colors = np.zeros((5, 5, own), np.float32), np.zeros((5, 5, other), np.float32)
    colors[..., own:] = 1.0  # of a format that has more components than the shader writes
    assert apart(colors, none=black) == 0
    colors[0, 0, 0] = 1.0
    assert apart(colors, depths=0.5, none=black) == 1


def test_passes_of_different_outputs_are_compared_as_one_program() -> None:
    """A driver may add in another order where it need not keep the other outputs."""
    rounded = np.full((5, 5, 1), 1e-7, np.float32)
    assert apart(rounded, depths=0.5) == 25
    assert apart(rounded, depths=0.5, alike=rounded) == 0
    wrong = rounded.copy()
    wrong[1:3, 1:3] = 1.0
    assert apart(wrong, depths=0.5, alike=rounded) == 4
