"""Formulas over integer outputs and over derivatives, from the shader to the record."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from shaderlab import Case, Ramp, Target, formula, fullscreen, glslmath as g, value
from shaderlab.engine.run import SceneRunner
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

SUMS = """#version 330 core
in vec2 p;
uniform int n;
out ivec3 sums;
out uvec2 bits;
void main() {
    int x = int(p.x * 100.0);
    sums = ivec3(n - 16777216 + x, n * n, x / 3);
    bits = uvec2(uint(n) << 3u, uint(x) ^ 255u);
}
"""
LARGE = """#version 330 core
in vec2 p;
uniform int n;
out float rest;
void main() { rest = float(n - 16777216) + p.x * 0.0; }
"""
SLOPES = """#version 330 core
in vec2 p;
out vec4 slopes;
void main() { vec2 q = p * p.yx; slopes = vec4(dFdx(q), dFdy(q)); }
"""


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions()) as made:
        yield made


@pytest.fixture
def run(lab: SceneRunner, tmp_path: Path) -> Callable[..., Record]:
    def judged(shader: str, *expect: Any, size: int = 16, **inputs: Any) -> Record:
        (tmp_path / "t.frag").write_text(shader)
        domain = {"p": Ramp((0.1, 0.2), (3.0, 0.7), (0.4, 2.0))}
        passes = fullscreen("t.frag", domain=domain, target=Target(size=(size, size)), **inputs)
        made = Case(title="t", id="t", file=str(tmp_path / "t.py"), passes=passes, expect=expect)
        return lab.run(made.scene("default"))

    return judged


def sums(p: Any, n: Any) -> Any:
    x = g.int(p.x * 100.0)
    return g.ivec3(n - 16777216 + x, n * n, x / 3)


def bits(p: Any, n: Any) -> Any:
    return g.uvec2(g.uint(n) << 3, g.uint(g.int(p.x * 100.0)) ^ 255)


def test_integer_outputs_are_judged_by_formulas(run: Callable[..., Record]) -> None:
    right = run(
        SUMS,
        formula("sums", sums),
        formula("bits", bits),
        value("bits", reference=bits, equals=(134217736, 251), digits=0, at={"p": (0.042, 0.0)}),
        uniforms={"n": 16777217},
    )
    assert right.status == "pass", right

    def off(p: Any, n: Any) -> Any:
        return sums(p, n) + g.ivec3(0, 1, 0)

    wrong = run(SUMS, formula("sums", off), formula("bits", bits), uniforms={"n": 16777217})
    assert wrong.status == "fail"


def test_a_float_of_a_large_integer_is_exact(run: Callable[..., Record]) -> None:
    def rest(n: Any) -> Any:
        return g.float(n - 16777216)

    def in_float32(n: Any) -> Any:
        return g.float(n - 16777217)

    assert run(LARGE, formula("rest", rest), uniforms={"n": 16777217}).status == "pass"
    assert run(LARGE, formula("rest", in_float32), uniforms={"n": 16777217}).status == "fail"


@pytest.mark.parametrize("size", [16, 15, 150])
def test_derivatives_are_judged_over_whole_quads(run: Callable[..., Record], size: int) -> None:
    """Of an odd size the last row and column have no neighbours; 150² pixels are two chunks."""

    def slopes(p: Any, frag_coord: Any) -> Any:
        q = p * p.yx
        return g.vec4(g.dFdx(q, frag_coord), g.dFdy(q, frag_coord))

    def exchanged(p: Any, frag_coord: Any) -> Any:
        return slopes(p, frag_coord).zwxy

    right = run(SLOPES, formula("slopes", slopes), size=size)
    assert right.expectations[0].outside == 0
    assert right.status == ("fail" if size == 15 else "pass")
    assert (right.expectations[0].vacuous > 0.01) == (size == 15)
    assert run(SLOPES, formula("slopes", exchanged), size=size).expectations[0].outside > 0
