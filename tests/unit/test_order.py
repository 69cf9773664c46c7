"""The same scene in the opposite order, and what is compared."""

from __future__ import annotations

import numpy as np

from shaderlab.expectations.any_order import any_order, both_ways
from shaderlab.expectations.exact import Exact
from shaderlab.model import Draw, Mesh, Output, Pass, Target


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
