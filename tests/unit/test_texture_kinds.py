"""Kinds of samplers that no case binds: a row is a plane that is one texel high, an array of cubes
is each of its cubes, and `diff`, `audit` and `explain` make some up."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from shaderlab.analysis.audit import audit_program
from shaderlab.analysis.comparison import Plan, compare_programs
from shaderlab.analysis.interpreter import FLOAT64, Bands, Program, interpret, load
from shaderlab.analysis.interpreter.arithmetic import Arithmetic
from shaderlab.compiler import Shaders
from shaderlab.model.frame import Bindings, Texels

ROWS = np.random.default_rng(2).random((12, 6, 6, 4)).astype(np.float32)
PLACES = np.random.default_rng(3).uniform(-1.5, 3.5, (64, 4)).astype(np.float32)
# Kind, its lookup, its texels; another kind's lookup that gives the same, and its texels.
SAME = {
    "a row": ("1D", "texture(s, p.x)", ROWS[0, :1], "2D", "texture(s, vec2(p.x, 0.5))"),
    "a row, projected": (
        "1D", "textureProj(s, vec2(p.x, 2.5))", ROWS[0, :1], "2D", "texture(s, vec2(p.x / 2.5, 0))",
    ),
    "rows": (
        "1DArray", "texture(s, p.xy)", ROWS[:, :1], "2DArray", "texture(s, vec3(p.x, 0.5, p.y))",
    ),
    "a texel of a row": (
        "1D", "texelFetchOffset(s, int(4.0 * fract(p.x)), 0, 1)", ROWS[0, :1],
        "2D", "texelFetch(s, ivec2(int(4.0 * fract(p.x)) + 1, 0), 0)",
    ),
    "a texel of rows": (
        "1DArray", "texelFetch(s, ivec2(5, 3), 0)", ROWS[:, :1],
        "2DArray", "texelFetch(s, ivec3(5, 0, 3), 0)",
    ),
    "a buffer": (
        "Buffer", "texelFetch(s, textureSize(s) - 1)", ROWS[0, :1],
        "2D", "texelFetch(s, ivec2(5, 0), 0)",
    ),
    "sizes": (
        "CubeArray", "vec4(textureSize(s, 0), 1)", ROWS, "2D", "vec4(textureSize(s, 0), 2, 1)",
    ),
    "the second cube": (
        "CubeArray", "texture(s, vec4(p.xyz, 0.7))", ROWS, "Cube", "texture(s, p.xyz)",
    ),
    "the first cube": (
        "CubeArray", "texture(s, vec4(p.xyz, -9))", ROWS, "Cube", "texture(s, p.xyz)",
    ),
}  # fmt: skip


def program(kind: str, lookup: str) -> Program:
    text = f"#version 430 core\nuniform sampler{kind} s; in vec4 p; out vec4 o;\n"
    return load(
        Shaders([]).from_text(f"{text}void main() {{ o = {lookup}; }}", "fragment", "a.frag")
    )


def texels(kind: str, values: Any) -> Bindings:
    made = Texels(values, ("linear", "linear"), ("repeat",) * 3, (0.0,) * 4, kind=kind)
    return Bindings(textures={"s": made})


@pytest.mark.parametrize("arithmetic", [FLOAT64, Bands()])
@pytest.mark.parametrize("name", SAME)
def test_it_gives_what_another_kind_does(name: str, arithmetic: Arithmetic) -> None:
    kind, lookup, values, other, its = SAME[name]
    own = values if other != "Cube" else values[6:] if "0.7" in lookup else values[:6]
    own = own if other != "2D" or own.ndim == 3 else own[0]
    found, expected = (
        interpret(program(k, how), {"p": PLACES}, texels(k, v), arithmetic).outputs["o"]
        for k, how, v in ((kind, lookup, values), (other, its, own))
    )
    for end in ("lo", "hi"):
        a, b = (np.asarray(getattr(v, end, v), np.float64) for v in (found, expected))
        np.testing.assert_allclose(np.broadcast_to(a, b.shape), b, atol=2e-6)


def test_which_cube_may_be_open() -> None:
    values = np.repeat(np.float32([0.0, 1.0]), 6)[:, None, None, None] * np.ones((12, 4, 4, 4))
    both = interpret(
        program("CubeArray", "texture(s, vec4(p.xyz, p.w / 0.6))"),
        {"p": np.float32([[1.0, 0.2, 0.1, 0.3]])}, texels("CubeArray", values.astype(np.float32)),
        Bands(),
    ).outputs["o"]  # fmt: skip
    assert both.lo.min() < 0.01 and both.hi.max() > 0.99


@pytest.mark.parametrize(
    ("kind", "lookup"),
    [
        ("1D", "texture(s, p.x)"), ("1DArray", "texture(s, p.xy)"), ("3D", "texture(s, p.xyz)"),
        ("CubeArray", "texture(s, p)"), ("Buffer", "texelFetch(s, int(abs(p.x)))"),
        ("1DShadow", "vec4(texture(s, p.xyz))"), ("CubeArrayShadow", "vec4(texture(s, p, p.x))"),
    ],
)  # fmt: skip
def test_without_a_case_some_are_made_up(kind: str, lookup: str) -> None:
    old, few = program(kind, lookup), Plan(rounds=1, count=256)
    assert compare_programs(old, program(kind, f"{lookup} * 1.0"), few).same is True
    assert compare_programs(old, program(kind, f"{lookup} * 1.001"), few).same is False
    assert audit_program(old).tried > 0
