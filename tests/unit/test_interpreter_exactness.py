"""Where interpreted bands know that nothing is rounded: multiples of a power of two, the zero that
a sum begins with, factors of 0 and 1, textures that are magnified at whatever level."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.adversary_device import Device
from benchmarks.erring_arithmetic import Erring, outside
from shaderlab.analysis.interpreter import FLOAT64, Bands, interpret, load
from shaderlab.bands import Band
from shaderlab.compiler import Shaders
from shaderlab.compiler.spirv import Op
from shaderlab.model.frame import Bindings, Texels

COUNT = 64
PLACES = {"p": np.random.default_rng(3).uniform(-40.0, 40.0, (COUNT, 2)).astype(np.float32)}


def band_of(expression: str, each: Any = None, arithmetic: Any = None) -> Any:
    text = f"#version 330 core\nin vec2 p; out vec2 color; void main() {{ {expression} }}"
    program = load(Shaders([]).from_text(text, "fragment", "t.frag"))
    run = interpret(program, each or PLACES, arithmetic=arithmetic or Bands())
    return run.outputs["color"]


def widest(band: Band) -> float:
    return float((band.hi - band.lo).max())


@pytest.mark.parametrize(
    "expression",
    [
        "color = vec2(mod(floor(p.x) + floor(p.y) + 0.5, 2.0) - 0.5);",
        "color = fract(0.5 * (floor(p) + 3.0 - round(p.yx)) + 0.25);",
        "float n = float(int(p.x)) * 4.0 - floor(p.y); color = vec2(n + 0.75, -n);",
        "color = mod(trunc(p) - 6.5, 3.0);",
    ],
)
def test_multiples_of_a_power_of_two_are_exact(expression: str) -> None:
    band = band_of(expression)
    assert widest(band) == 0.0
    for seed in range(3):
        theirs = band_of(expression, arithmetic=Erring(device=Device(seed, "either")))
        assert outside(band, theirs) == 0
    wrong = np.nextafter(band.lo.astype(np.float32), np.float32(np.inf))
    assert not band.contains(wrong).any()


@pytest.mark.parametrize(
    "expression",
    [
        "color = vec2(mod(floor(p.x) + floor(p.y) + 0.3, 2.0) - 0.3);",  # 0.3 is no multiple
        "color = floor(p) * 1048576.0 + 0.125 + floor(p.yx);",  # more than 24 bits
        "color = floor(p) + p + 1.0;",
    ],
)
def test_what_may_be_rounded_is_not(expression: str) -> None:
    assert widest(band_of(expression)) > 0.0


def test_a_rounding_stays_pending_where_something_else_is_added() -> None:
    """(⌊x⌋ + ⌊y⌋ + ½) + s may be added up as (⌊x⌋ + s) + ⌊y⌋ + ½, which rounds at ⌊x⌋."""
    x, y = PLACES["p"].T
    small = np.float32(1e-3) * PLACES["p"][:, 0]
    band = band_of("color = vec2(floor(p.x) + floor(p.y) + 0.5 + 0.001 * p.x);")
    ordered = [(np.floor(x) + small) + np.floor(y) + np.float32(0.5),
               (np.floor(y) + (small + np.float32(0.5))) + np.floor(x)]  # fmt: skip
    for values in ordered:
        assert band.contains(np.stack([values, values], axis=-1)).all()


def test_a_sum_begins_with_no_term_and_a_factor_of_one_rounds_nothing() -> None:
    loop = "vec2 s = vec2(0.0); for (int i = 0; i < 3; ++i) s += p * 0.3; color = s;"
    plain = "vec2 s = p * 0.3; color = s + s + s;"
    assert widest(band_of(loop)) == widest(band_of(plain))
    kept, stepped = (band_of(f"color = (p + 0.1){by};") for by in ("", " * step(p.yx, vec2(50.0))"))
    assert np.array_equal(kept.lo, stepped.lo) and np.array_equal(kept.hi, stepped.hi)
    assert widest(band_of("color = (p + 0.1) * 0.3;")) > widest(stepped) * 0.3


@pytest.mark.parametrize(("size", "exact"), [(1.0 / 64.0, True), (8.0, False)])
def test_how_far_a_texture_is_magnified_does_not_matter(size: float, exact: bool) -> None:
    y, x = np.mgrid[:4, :4].reshape(2, -1)
    each = {
        "p": np.stack([x, y], -1) * size / 4.0,
        "gl_FragCoord": np.stack([x + 0.5, y + 0.5], -1),
    }
    texels = np.random.default_rng(5).random((4, 4, 4)).astype(np.float32)
    image = Texels(texels, ("linear", "nearest"), ("repeat",) * 2, (0.0,) * 4)
    text = """#version 330 core
    in vec2 p; uniform sampler2D t; out vec4 color; void main() { color = texture(t, p + 0.1); }"""
    program = load(Shaders([]).from_text(text, "fragment", "t.frag"))
    bindings = Bindings(textures={"t": image})
    band = interpret(program, each, bindings, Bands()).outputs["color"]
    assert (widest(band) < 1e-5) is exact


FOLDED = {
    "0.2126 * 0.9": lambda f: f(0.2126) * f(0.9),
    "pow(0.73, 2.2)": lambda f: f(0.73) ** f(2.2),
    "pow(0.9, 5.0)": lambda f: f(0.9) ** f(5.0),
    "acos(0.2)": lambda f: np.arccos(f(0.2)),
    "mod(5.3, 0.7)": lambda f: f(5.3) - f(0.7) * np.floor(f(5.3) / f(0.7)),
    "fract(43.7)": lambda f: f(43.7) - f(43.0),
    "(0.52 - 0.02)": lambda f: f(0.52) - f(0.02),
    "1.0 / 2.2": lambda f: f(1.0) / f(2.2),
    "float(3) / 7.0": lambda f: f(3.0) / f(7.0),
}


@pytest.mark.parametrize("expression", FOLDED)
def test_constants_may_be_folded_in_float32_or_in_float64(expression: str) -> None:
    code = f"const float k = {expression}; color = vec2(k, ({expression}) * p.x);"
    band = band_of(code)
    for precision in (np.float32, np.float64):
        constant = np.full(COUNT, FOLDED[expression](precision), np.float32)
        folded = np.stack([constant, constant * PLACES["p"][:, 0]], axis=-1)
        assert band.contains(folded).all()


def test_a_literal_keeps_its_digits_and_its_line() -> None:
    text = "#version 330 core\n#define PI 3.14159265\nout float color;\nvoid main()\n{\n"
    source = Shaders([]).from_text(text + "    color = 2.0 * PI;\n}\n", "fragment", "t.frag")
    program = load(source)
    assert interpret(program, {}, arithmetic=FLOAT64).outputs["color"] == 2.0 * 3.14159265
    assert program.line_of(Op.FMul) == 6
