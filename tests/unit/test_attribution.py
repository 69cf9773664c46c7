"""The cause of a disagreement, from what was seen on both drivers; and what triangles cover."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from shaderlab import Cell, Mesh, State
from shaderlab.engine.rasterised import covered, interpolated
from shaderlab.model.frame import Samples
from shaderlab.model.observations import Fault, Observation
from shaderlab.model.records import Disagreement
from shaderlab.workers.attribution import attributed
from shaderlab.workers.difference_pictures import shades

FOUND = Disagreement(
    id="lamp", variant="default", output="main.color", drivers=("llvmpipe", "softpipe"),
    pixels=4, differing=1, ulp=2.0, verdict="within",
)  # fmt: skip
SEEN = Observation(
    output="main.color", seen=(0, 0), inputs=({"uv": (0.5,)}, {"uv": (1.0,)}),
    at_edge=(False, True), vertices={"0": "aa"},
)  # fmt: skip
OTHER_UV = ({"uv": (0.5,)}, {"uv": (1.0 + 2.0**-22,)})


@pytest.mark.parametrize(
    ("one", "two", "cause"),
    [
        ({}, {}, "arithmetic"),
        ({"samples_textures": True}, {}, "texels"),
        ({"after": "blending"}, {}, "fixed function"),
        ({"reads": ("before.color",)}, {}, "earlier pass"),
        ({}, {"inputs": OTHER_UV}, "interpolation"),
        ({}, {"inputs": OTHER_UV, "vertices": {"0": "bb"}}, "vertex stage"),
        ({}, {"seen": (0, -1)}, "rasterisation"),
        ({}, {"seen": (1, 0)}, "visibility"),
        ({}, {"seen": (1, 0), "vertices": {"0": "bb"}}, "vertex stage"),
    ],
)
def test_the_first_input_that_differs_is_the_cause(
    one: dict[str, Any], two: dict[str, Any], cause: str
) -> None:
    found = attributed(FOUND, replace(SEEN, **one), replace(SEEN, **two))
    assert (found.cause, found.verdict, found.outside) == (cause, "within", ())


@pytest.mark.parametrize("pair", [("llvmpipe", "llvmpipe-spirv"), ("webgl2", "swiftshader")])
def test_between_two_paths_to_one_compiler_arithmetic_is_translation(pair: tuple[str, str]) -> None:
    found = attributed(replace(FOUND, drivers=pair), SEEN, SEEN)
    assert found.cause == "translation"
    others = attributed(replace(FOUND, drivers=(pair[0], "lavapipe")), SEEN, SEEN)
    assert others.cause == "arithmetic"


def test_a_fault_is_blamed_whatever_else_differs() -> None:
    fault = Fault(kind="coverage", text="draw 0 leaves out pixel (1, 1)")
    found = attributed(FOUND, replace(SEEN, inputs=OTHER_UV), replace(SEEN, fault=fault))
    assert (found.verdict, found.outside, found.cause) == ("outside", ("softpipe",), "coverage")
    assert found.why == "softpipe: draw 0 leaves out pixel (1, 1)"
    failed = replace(FOUND, verdict="outside", outside=("llvmpipe",))
    both = attributed(failed, SEEN, replace(SEEN, fault=fault))
    assert both.outside == ("llvmpipe", "softpipe")


def test_what_was_not_looked_at_says_so() -> None:
    assert "could not be drawn" in attributed(FOUND, None, SEEN).why
    hidden = replace(SEEN, seen=(-1, -1), refused=("the pass is too large",))
    assert attributed(FOUND, hidden, hidden).why == "not looked at: the pass is too large"


CORNERS = np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]], np.float32)  # of an 8 × 8 target
PIXELS = np.array([[1, 1], [6, 6], [3, 4], [4, 4]])


def looked(primitive: str, state: State, w: float = 1.0) -> Any:
    order = {"triangles": [0, 1, 2], "triangle_strip": [0, 1, 2, 3], "triangle_fan": [0, 1, 3, 2]}
    place = np.concatenate([CORNERS, np.zeros((4, 1)), np.ones((4, 1))], axis=1) * w
    mesh = Mesh(attributes={"at": CORNERS}, indices=np.array(order[primitive]), primitive=primitive)
    given = Samples(inputs={}, outputs={"gl_Position": place.astype(np.float32)})
    return covered(mesh, 1, given, state, (8, 8), PIXELS), given.outputs["gl_Position"]


def test_triangles_cover_what_lies_in_them_and_edges_are_left_open() -> None:
    found, _ = looked("triangles", State())
    assert found.inside.tolist() == [True, False, False, False]
    assert found.possible.tolist() == [True, False, True, False]  # (3, 4) is cut by the edge
    strip, _ = looked("triangle_strip", State())
    assert strip.inside.tolist() == [True, True, False, True]
    fan, _ = looked("triangle_fan", State())  # its inner edge is the other diagonal
    assert fan.inside.tolist() == [False, False, True, False] and fan.possible.all()


@pytest.mark.parametrize(
    "state",
    [
        State(cull="front"), State(cull="back", front_face="cw"), State(cull="front_and_back"),
        State(scissor=(4, 4, 4, 4)), State(cell=Cell(column=1, row=1, columns=2, rows=2)),
    ],
)  # fmt: skip
def test_what_is_dropped_covers_nothing(state: State) -> None:
    found, _ = looked("triangles", state)
    assert not found.inside[:1].any() and not found.possible[:1].any()


def test_a_triangle_that_is_clipped_may_cover_anything() -> None:
    found, _ = looked("triangles", State(), w=-1.0)
    assert not found.inside.any()


def test_values_between_corners_follow_from_perspective() -> None:
    found, place = looked("triangles", State())
    place = place * np.array([[1.0], [3.0], [1.0], [1.0]], np.float32)
    values = np.array([[0.0], [8.0], [0.0], [0.0]])
    flat, _ = interpolated(values, place, found, 0, "flat")
    linear, give = interpolated(values, place, found, 0, "noperspective")
    smooth, _ = interpolated(values, place, found, 0, "smooth")
    share = 1.5 / 8.0
    assert flat == 0.0 and linear == pytest.approx(8.0 * share) and 0.0 < give < 0.5
    assert smooth == pytest.approx(8.0 * share / 3.0 / (1.0 - share + share / 3.0))


def test_pictures_of_differences_grow_darker_and_small() -> None:
    apart = np.zeros((2, 641))
    apart[0, 640], apart[1, 0], apart[0, 5] = np.inf, 1.0, 3000.0
    made = shades(apart)
    assert made.shape == (1, 214) and made[0, 213] == 4
    assert (made[0, 0], made[0, 1], made[0, 2]) == (1, 2, 0)
