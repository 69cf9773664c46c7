"""A draw that shows no pixel is called that, whatever hides it and whatever is expected of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Case,
    Cell,
    Depth,
    Draw,
    Mesh,
    Pass,
    Pixel,
    State,
    Stencil,
    Target,
    boundaries,
    formula,
    value,
)
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import step, swizzle, vec4
from shaderlab.model.records import Record

VERTEX = """#version 330 core
layout (location = 0) in vec3 aPos;
uniform float aside;
out vec2 place;
void main() { place = aPos.xy; gl_Position = vec4(aPos.x + aside, aPos.yz, 1.0); }
"""
FRAGMENT = """#version 330 core
in vec2 place;
uniform float edge;
out vec4 FragColor;
void main() { if (place.x > edge) discard; FragColor = vec4(step(0.5, place.x), place, 1.0); }
"""
CORNERS = np.array([(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)])
SQUARE = Mesh(attributes={"aPos": CORNERS}, indices=np.array([0, 1, 2, 0, 2, 3]))
SEEN = {"aside": 0.0, "edge": 2.0}
HIDDEN: dict[str, dict[str, Any]] = {
    "culled": {"state": State(cull="front")},
    "wound the other way": {"state": State(cull="back", front_face="cw")},
    "by its depth": {"state": State(depth=Depth(func="greater"))},
    "by the stencil": {"state": State(stencil=Stencil(func="never"))},
    "outside": {"uniforms": {**SEEN, "aside": 3.0}},
    "discarded": {"uniforms": {**SEEN, "edge": -2.0}},
}


def colored(place: Any) -> Any:
    return vec4(step(0.5, swizzle(place, "x")), place, 1.0)


def judged(folder: Path, expect: Any, *later: Draw, **changes: Any) -> Record:
    (folder / "square.vert").write_text(VERTEX)
    (folder / "square.frag").write_text(FRAGMENT)
    shaders = {"vertex": "square.vert", "fragment": "square.frag", "mesh": SQUARE}
    draw = Draw(**{**shaders, "uniforms": SEEN, **changes})
    target = Target(size=(16, 16), depth="depth24_stencil8")
    file = str(folder / "square.py")
    one = Pass(name="main", target=target, draws=(draw, *later))
    case = Case(id="square", title="Square", file=file, passes=(one,), expect=[expect])
    with SceneRunner() as lab:
        return lab.run(next(case.scenes()))


@pytest.mark.parametrize("hidden", HIDDEN)
@pytest.mark.parametrize("kind", [formula, boundaries])
def test_what_covers_no_pixel_fails_and_says_so(tmp_path: Path, kind: Any, hidden: str) -> None:
    record = judged(tmp_path, kind("FragColor", colored), **HIDDEN[hidden])
    (outcome,) = record.expectations
    assert (record.status, outcome.status) == ("fail", "fail"), record.message
    assert "no pixel is covered" in outcome.message and "culling" in outcome.message


@pytest.mark.parametrize("kind", [formula, boundaries])
def test_so_does_what_a_later_draw_hides(tmp_path: Path, kind: Any) -> None:
    shaders = {"vertex": "square.vert", "fragment": "square.frag", "mesh": SQUARE}
    record = judged(tmp_path, kind("FragColor", colored, draw=0), Draw(**shaders, uniforms=SEEN))
    (outcome,) = record.expectations
    assert outcome.status == "fail" and "later draws" in outcome.message


def test_a_value_of_a_pixel_says_whether_the_draw_is_there(tmp_path: Path) -> None:
    left = State(cell=Cell(column=0, row=0, columns=2, rows=1))
    for x, found in ((2, False), (12, True)):
        wrong = value(
            "FragColor", at=Pixel(x, 8), equals=(0.5, 0.5, 0.5, 0.5), digits=2, reference=colored
        )
        (outcome,) = judged(tmp_path, wrong, state=left).expectations
        assert outcome.status == "fail"
        assert ("does not cover this pixel" in outcome.message) == found


@pytest.mark.parametrize("kind", [formula, boundaries])
def test_the_same_draw_passes_where_it_is_seen(tmp_path: Path, kind: Any) -> None:
    record = judged(tmp_path, kind("FragColor", colored))
    assert record.status == "pass", record
