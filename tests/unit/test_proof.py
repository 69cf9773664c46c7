"""What holds for all inputs is proved, what does not is refuted, and nothing is proved wrongly."""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.proving import Case, cases, find_escapes
from benchmarks.proving_adversary import leave_boxes, make_case
from shaderlab import glsl, glslmath as g
from shaderlab.analysis.audit import Plan, audit_program
from shaderlab.analysis.batches import InputBatch, run_batch
from shaderlab.analysis.boxes import ARITHMETIC, Space, ends_of
from shaderlab.analysis.inputs import domains_of, inputs_of
from shaderlab.analysis.interpreter import load
from shaderlab.analysis.proof import Proof
from shaderlab.bands import Band, Rules
from shaderlab.cli import cli
from shaderlab.compiler import Shaders
from shaderlab.engine.worker import Worker
from shaderlab.errors import CallError
from shaderlab.functions.evaluation import use_worker
from shaderlab.model.frame import Bindings, Texels

OPEN = {"rgb_to_hsv"}
"""What is safe but not proved: a variable occurs in both operands of a minimum."""
ALL = {(case.planted, case.name): case for case in cases()}


@pytest.fixture(scope="module")
def worker() -> Worker:
    return Worker()


@pytest.fixture
def few_boxes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shaderlab.analysis.audit.BOXES", 8192)


def said(case: Case, worker: Worker) -> str:
    audit = case.audit(worker)
    assert not audit.refused
    return "refuted" if audit.hazards else "proved" if audit.clean else "open"


@pytest.mark.parametrize("name", [n for planted, n in ALL if not planted and n not in OPEN])
def test_safe_functions_are_proved_and_no_input_escapes(name: str, worker: Worker) -> None:
    case = ALL[False, name]
    assert said(case, worker) == "proved"
    assert find_escapes(case, worker, 2000, seed=7) == 0


@pytest.mark.parametrize("name", [n for planted, n in ALL if planted])
def test_planted_hazards_are_refuted(
    name: str, worker: Worker, monkeypatch: pytest.MonkeyPatch
) -> None:
    if name != "linear_depth":  # whose input is found late
        monkeypatch.setattr("shaderlab.analysis.audit.BOXES", 8192)
    assert said(ALL[True, name], worker) == "refuted"


def test_bounds_of_ranges_hold_wherever_terms_cancel() -> None:
    # x + y is as large as its terms at one end, and cancels at the other: it may round below 0.
    rules = Rules(ranges=True)
    x, y = Band.between([1.0], [2.0], rules), Band.between([-1.0], [1.0], rules)
    z = Band.between([0.0], [1.0], rules)
    assert ((x + y) + z).lo[0] < 0.0
    assert ((z + z * z) + z).lo[0] == 0.0  # no term is negative


@pytest.mark.usefixtures("few_boxes")
def test_what_overflows_may_become_nan() -> None:
    for rules in (Rules(), Rules(ranges=True)):
        huge = Band.between([1e30], [1e31], rules)
        assert ((huge * huge) * 0.0).nan.all(), "infinity times 0"
    x, y = (Band.between([1e29], [1e30], Rules(ranges=True)) for _ in "xy")
    assert ((x - y) * (x - y * 2.0)).nan.all(), "x² − 2 x y − … is infinity minus infinity"
    assert g.log2(huge * huge).hi == np.inf == g.log2(Band.exact([np.inf])).lo
    small = g.exp2(Band.between([-181.0], [-160.0]))
    assert small.hi >= (3 + 2 * 181) * 2.0**-149, "of subnormal results the least errs most"
    product = (x * (y * 1e-30)) * 0.5
    assert product.contains(np.float32(np.inf)).all(), "x y overflows before it gets small"
    power = g.log(g.exp(Band.exact([3e13])))
    assert power.lo < 3e13 and power.hi == np.inf, "a compiler may take log(exp(x)) for x"


@pytest.mark.parametrize("condition", ["s > top", "!!(s > top)"])
def test_a_condition_that_nan_makes_false_bounds_nothing(condition: str, worker: Worker) -> None:
    """clamp(NaN, 0, 1) may be NaN: then s > 1 goes on, as if it were not greater."""
    code = (
        "float f(float x, float y) { float s = y + 1.0, top = clamp(inversesqrt(x), 0.0, 1.0);"
        f" if ({condition}) return 0.0; return s; }}"
    )
    program = Case("nan", False, code, {}).program(worker)
    ranges = {"x": "-2:-1", "y": "0:1"}
    inputs = inputs_of(program)
    space = Space(program, inputs, domains_of(inputs, [program], ranges))
    box = space.ranges(space.low[None], space.high[None])
    low, high = ends_of(run_batch(program, box, ARITHMETIC).outputs["result"])
    assert low.item() <= 0.0 and high.item() >= 2.0


def test_what_is_open_is_said_and_what_is_assumed(tmp_path: Path) -> None:
    (tmp_path / "law.glsl").write_text(
        "float far(float a, float b) { return 1.0 / (a - b); }\n"
        "float root(float x) { float y; if (x > 0.5) y = x; return sqrt(y); }\n"
        "float turns(float x) { float s = 0.0; while (s < x) s += x * x; return s; }\n"
        "float slope(float x) { return 1.0 / dFdx(x); }\n"
        "float texel(sampler2D t, vec2 p) { return sqrt(texture(t, p).x - 0.5); }\n"
    )
    words = ["prove", str(tmp_path / "law.glsl"), "-j", "0", "--range", "x=0:1"]
    words += ["--range", "a=1:2", "--range", "b=1:2", "--assume", "a > b + 0.5"]
    result = CliRunner().invoke(cli, words)
    assert result.exit_code == 1, result.output
    lines = result.output
    assert "law.glsl:1: proved: no division by 0 in far" in lines
    assert "proved: no sqrt of a negative number in root" not in lines
    assert "proved: no division by 0 in slope" not in lines
    assert "proved: result is a finite number in turns" not in lines
    assert "law.glsl:5: sqrt of a negative number" in lines
    assert "far: b: 1..2 (given)" in lines


@pytest.mark.usefixtures("few_boxes")
def test_parts_without_a_value_are_no_squares(worker: Worker) -> None:
    code = "struct S { float p; float q; }; float f(float x) { S s; return x + sqrt(s.p * s.q); }"
    audit = Case("none", True, code, {"x": "0:1"}).audit(worker)
    assert [claim.status for claim in audit.claims if claim.line] == ["open"]


BOTH = "inversesqrt(x * x + 1e-40)", "inversesqrt(x + 1.0)"


@pytest.mark.usefixtures("few_boxes")
@pytest.mark.parametrize("order", [BOTH, BOTH[::-1]])
def test_a_line_is_proved_only_where_all_of_it_is(order: tuple[str, str], worker: Worker) -> None:
    code = f"float f(float x) {{ return {order[0]} + {order[1]}; }}"
    audit = Case("both", False, code, {"x": "0:1"}).audit(worker)
    assert not audit.hazards
    assert {claim.status for claim in audit.claims} == {"open"}


@pytest.mark.usefixtures("few_boxes")
def test_a_line_with_a_refuted_place_is_not_proved_besides(worker: Worker) -> None:
    code = "float f(float x) { return 1.0 / x + 1.0 / (x + 1.0); }"
    audit = Case("beside", True, code, {"x": "0:1"}).audit(worker)
    assert len(audit.hazards) == 1
    assert "no division by 0" not in {claim.what for claim in audit.claims}


ENDLESS = """float f(float x) {
    float y = sqrt(x), d = (y * 3.0 - y * 2.0) - y;
    int n = 0;
    while (float(n) * 1e-6 < abs(d) - 1e-6) ++n;
    return 1.0 / (float(n) - 5.0);
}"""


def test_what_can_not_be_run_in_boxes_is_open(worker: Worker) -> None:
    program = Case("endless", False, ENDLESS, {"x": "0:1"}).program(worker)
    inputs = inputs_of(program)
    proof = Proof(program, inputs, domains_of(inputs, [program], {"x": "0:1"}), boxes=8192)
    (claim,) = proof.claims()
    assert claim.status == "open" and claim.share == 1.0 and "goes on after" in claim.note


@pytest.mark.usefixtures("few_boxes")
def test_a_refutation_is_run_on_the_driver(tmp_path: Path) -> None:
    (tmp_path / "glow.frag").write_text(
        "#version 330 core\nstruct Light { vec3 at; float reach; };\nuniform Light light;\n"
        "uniform float weights[2]; // range: 0..1\nin vec2 uv;\nout vec4 color;\n"
        "void main() { color = vec4(light.at, 1.0 / (light.reach * weights[1] + 0.0 * uv.x)); }\n"
    )
    words = ["audit", "--prove", str(tmp_path / "glow.frag"), "-j", "0"]
    result = CliRunner().invoke(cli, [*words, "--range", "light.reach=0:1"])
    assert result.exit_code == 1
    (line,) = [one for one in result.output.splitlines() if "on the driver" in one]
    assert "inf" in line or "nan" in line
    assert np.char.count(result.output, "division by 0") >= 1


FUNCTIONS = {
    "sqrt": 1, "inversesqrt": 1, "exp": 1, "log2": 1, "sin": 1, "cos": 1, "tan": 1, "asin": 1,
    "acos": 1, "atan": 2, "pow": 2, "abs": 1, "sign": 1, "floor": 1, "fract": 1, "round": 1,
    "mod": 2, "min": 2, "max": 2, "clamp": 3, "mix": 3, "step": 2, "smoothstep": 3, "sinh": 1,
    "tanh": 1, "asinh": 1, "acosh": 1, "atanh": 1, "fma": 3, "modf": 1, "frexp": 1, "int": 1,
    "uint": 1, "floatBitsToInt": 1, "dot": 2, "length": 1, "distance": 2, "normalize": 1,
    "reflect": 2, "refract": 3, "faceforward": 3, "cross": 2, "packHalf2x16": 1,
    "packUnorm4x8": 1, "degrees": 1,
}  # fmt: skip
SIZES = {"cross": 3, "dot": 3, "length": 3, "distance": 3, "normalize": 3, "reflect": 3,
         "refract": 3, "faceforward": 3, "packHalf2x16": 2, "packUnorm4x8": 4}  # fmt: skip


def parts_of(value: Any) -> list[Any]:
    return (
        [part for one in value for part in parts_of(one)] if isinstance(value, tuple) else [value]
    )


@pytest.mark.parametrize("name", FUNCTIONS)
def test_values_of_a_function_lie_in_what_its_ranges_give(name: str) -> None:
    rng = np.random.default_rng(3)
    rules, function, boxes, points = (
        Rules(trig_outside="scaled", ranges=True),
        getattr(g, name),
        300,
        40,
    )
    lows, highs, values = [], [], []
    for i in range(FUNCTIONS[name]):
        size = 1 if name == "refract" and i == 2 else SIZES.get(name, 1)
        middle = rng.normal(size=(boxes, size)) * 10.0 ** rng.uniform(-3, 1, (boxes, 1))
        half = np.abs(middle) * rng.choice([0.0, 1e-3, 0.5, 3.0], (boxes, 1))
        low, high = np.float32(middle - half), np.float32(middle + half)
        share = rng.choice([0.0, 1.0, 0.5, rng.random()], (boxes, points, size))
        inside = low[:, None] + share * (high - low)[:, None]
        values.append(np.clip(inside.astype(np.float32), low[:, None], high[:, None]))
        lows.append(low), highs.append(high)
    bands = [Band.between(low, high, rules) for low, high in zip(lows, highs, strict=True)]
    with np.errstate(all="ignore"):
        whole = parts_of(function(*bands))
        flat = [v.reshape(boxes * points, -1).astype(np.float64) for v in values]
        found = parts_of(function(*flat))
    for band, value in zip(whole, found, strict=True):
        numbers = np.asarray(getattr(value, "lo", value), np.float64).reshape(boxes, points, -1)
        low, high = band.lo[:, None], band.hi[:, None]
        give = 1e-6 * np.abs(numbers) + 1e-37
        inside = (numbers >= low - give) & (numbers <= high + give) | np.isnan(numbers)
        assert inside.all(), [v.reshape(boxes, points, -1)[~inside.all(-1)][:3] for v in values]


def test_conditions_of_results_are_proved_or_broken() -> None:
    library = glsl.load("""
        struct Lamp { float reach; };
        float near(float share) { float s = clamp(1.0 - share, 0.0, 1.0); return s * s; }
        float fade(float d, Lamp lamp) { return near(d / lamp.reach); }
        vec3 turned(vec3 v) { return normalize(v); }
        float half_of(float x) { return x / (1.0 + x); }
    """)
    library.fade.prove(lambda y: (y >= 0.0) & (y <= 1.0), d=(0, 50), lamp_reach=(1, 20))
    library.turned.prove(lambda v: (v >= -1.0001) & ~g.isnan(v), v="unit")
    with pytest.raises(AssertionError, match=r"d = 0, lamp_reach = 0\n.*nan\n    on the driver"):
        library.fade.prove(lambda y: ~g.isnan(y), d=(0, 50), lamp_reach=(0, 20))
    with pytest.raises(AssertionError, match="open: the law holds, on"):
        library.half_of.prove(lambda y: y <= 0.5, x=(0, 1))
    with pytest.raises(CallError, match="lamp_reach has no range"):
        library.fade.prove(lambda y: y >= 0.0, d=(0, 1))


def test_laws_of_checks_are_proved_or_broken() -> None:
    library = glsl.load("""
        float near(float s) { float t = clamp(1.0 - s, 0.0, 1.0); return t * t; }
        float fade(float d, float reach) { return near(d / reach); }
        float drops(float x) { return x - (x > 0.5 ? 0.1 : 0.0); }
        float dips(float x) { return x - (x > 0.5 ? 0.01 : 0.0); }
        float even_of(float x) { return x * x / (1.0 + abs(x)); }
        float nearer(float a, float b) { return min(a * 1.01, b); }
    """)
    falls = glsl.monotone("d", direction="decreasing")
    library.fade.prove(falls, d=(0, 50), reach=(8, 12))
    library.fade.prove(glsl.bounded(0, 1), d=(0, 50), reach=(8, 12))
    library.dips.prove(glsl.monotone("x", strict=True), x=(0, 1))  # not seen 1/64 apart
    library.even_of.prove(glsl.even("x", within=0.05), x=(-4, 3))
    library.nearer.prove(glsl.symmetric(("a", "b"), within=0.04), a=(0, 2), b=(0, 2))
    for broken in (
        lambda: library.fade.prove(glsl.monotone("d"), d=(0, 50), reach=(8, 12)),
        lambda: library.fade.prove(glsl.bounded(0, 0.9), d=(0, 50), reach=(8, 12)),
        lambda: library.nearer.prove(glsl.symmetric(("a", "b")), a=(0, 2), b=(0, 2)),
        lambda: library.even_of.prove(glsl.odd("x", within=0.05), x=(-4, 3)),
    ):
        with pytest.raises(AssertionError, match=r"breaks the law with (.|\n)*on the driver"):
            broken()
    for law in (glsl.bounded(low=0.0), glsl.bounded(0.0, 1e39)):  # infinity is not between
        with pytest.raises(AssertionError, match="inf"):
            library.even_of.prove(law, x=(1e20, 1e30))
        with pytest.raises(AssertionError, match="inf"):
            library.even_of.check(law, [1e20, 1e30])
    with pytest.raises(AssertionError, match=r"the law holds, on|breaks the law"):
        library.drops.prove(glsl.monotone("x"), x=(0, 1))
    with pytest.raises(CallError, match="reach has no range"):
        library.fade.prove(glsl.monotone("reach"), d=(0, 1))
    with pytest.raises(CallError, match="monotone is proved of one result, and floats of d, reach"):
        library.fade.prove(glsl.monotone("q"), d=(0, 1), reach=(1, 2))


@pytest.mark.usefixtures("few_boxes")
def test_derivatives_are_those_of_a_quad(tmp_path: Path) -> None:
    (tmp_path / "edge.frag").write_text(
        "#version 330 core\nin vec2 uv;\nuniform float x; // range: 0..1\nout vec4 color;\n"
        "void main() { float w = max(fwidth(uv.x), 0.001);\n"
        "color = vec4(sqrt(x) + clamp(uv.x / w, 0.0, 1.0), uv, 1.0); }\n"
    )
    words = ["audit", "--prove", str(tmp_path / "edge.frag"), "-j", "0"]
    result = CliRunner().invoke(cli, words)
    assert "no hazards" in result.output, result.output  # one invocation alone has no derivative
    assert "edge.frag:6: proved: no division by 0" in result.output


def test_values_of_random_functions_lie_in_their_boxes(worker: Worker) -> None:
    tally: Counter[str] = Counter()
    for seed in (*range(40, 45), 93_457, 93_568):
        case = make_case(random.Random(seed))
        with use_worker(worker):
            assert not leave_boxes(case, case.program(worker), seed, tally)
    assert tally["values of the driver"] > 10_000


LIT = """#version 330 core
in vec3 n; uniform vec3 up; uniform float weights[2]; uniform sampler2D map; out vec4 color;
void main() {
    float shade = sqrt(textureLod(map, n.xy, 0.0).x - 0.25);
    color = vec4(normalize(n) * shade, 1.0 / (weights[1] + up.x));
}"""


def draw(weight: float, texel: float) -> InputBatch:
    v = np.random.default_rng(int(weight + 9.0)).normal(size=(50, 3))
    normals = np.float32(v / np.linalg.norm(v, axis=1, keepdims=True) * 0.9)
    texels = Texels(np.full((2, 2, 4), texel, "f4"), ("nearest",) * 2, ("repeat",) * 2, (0.0,) * 4)
    uniforms = {"up": np.float32([1, 0, 0]), "weights": np.float32([[0], [weight]])}
    textures = {"map": texels, "of_the_vertex_stage": texels}
    bindings = Bindings(uniforms=uniforms, textures=textures, arrays=frozenset({"weights"}))
    return InputBatch({"n": normals, "gl_FragCoord": np.ones((50, 4), "f4")}, bindings, 50)


@pytest.mark.parametrize(("weights", "opened"), [((1.0, 3.0), set()), ((-1.5, 3.0), {5})])
def test_what_draws_give_is_proved_between_their_ends(
    weights: tuple[float, ...], opened: set[int]
) -> None:
    program = load(Shaders([]).from_text(LIT, "fragment", "lit.frag"))
    draws = [draw(weight, 0.5) for weight in weights]
    audit = audit_program(program, Plan(prove=True), draws)
    assert {c.line for c in audit.claims if c.line and c.status == "open"} == opened
    kinds = {claim.what for claim in audit.claims if claim.status == "proved"}
    assert kinds >= {"no normalize of a zero vector", "no sqrt of a negative number"}
    assert audit.inputs["weights[1]"] == f"{weights[0]:g}..3 (in the case)"
    assert audit.inputs["n"].endswith("of length 0.899999..0.900001 (in the case)")
    darker = audit_program(program, Plan(prove=True), [*draws, draw(3.0, 0.125)])
    assert "no sqrt of a negative number" in {c.what for c in darker.claims if c.status == "open"}


def test_what_is_fetched_from_outside_of_a_texture_may_be_0() -> None:
    text = LIT.replace("textureLod(map, n.xy, 0.0)", "texelFetch(map, ivec2(9), 0)")
    program = load(Shaders([]).from_text(text, "fragment", "lit.frag"))
    audit = audit_program(program, Plan(prove=True), [draw(3.0, 0.5)])
    assert "no sqrt of a negative number" in {c.what for c in audit.claims if c.status == "open"}


def test_a_case_is_proved_between_what_its_draws_give() -> None:
    words = ["audit", "--prove", "spotlight-hard", "-j", "0"]
    result = CliRunner().invoke(cli, words)
    assert result.exit_code == 0, result.output
    assert "spotlight_hard.frag:33: proved: no normalize of a zero vector" in result.output
