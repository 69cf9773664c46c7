"""Shaders read as arithmetic: each family of instructions against `glslmath`, control flow, inputs
by name, the trace, and what is refused."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from benchmarks.adversary_device import Device
from benchmarks.erring_arithmetic import Erring, outside
from shaderlab import glslmath as g
from shaderlab.analysis.interpreter import (
    FLOAT16,
    FLOAT32,
    FLOAT64,
    Bands,
    Interpreted,
    Program,
    Stored,
    interpret,
    load,
    read,
)
from shaderlab.bands import Band, Integer, Rules
from shaderlab.compiler import Shaders
from shaderlab.errors import FormulaError, NotInterpretedError, ShaderError
from shaderlab.glslmath import sampling
from shaderlab.model.frame import Bindings, Texels

RNG = np.random.default_rng(19)
COUNT = 64
INPUTS = {
    "a": RNG.uniform(0.1, 1.0, (COUNT, 4)).astype(np.float32),
    "b": RNG.uniform(-2.0, 2.0, (COUNT, 4)).astype(np.float32),
    "n": RNG.integers(-100, 100, (COUNT, 4)).astype(np.int32),
    "m": RNG.integers(0, 2**32, (COUNT, 4), dtype=np.uint32),
}
DECLARED = """in vec4 a; in vec4 b; flat in ivec4 n; flat in uvec4 m;
out vec4 color; out ivec4 whole;
"""


@functools.cache
def program(text: str, stage: str = "fragment", version: str = "330 core") -> Program:
    return load(Shaders([]).from_text(f"#version {version}\n{text}", stage, f"t.{stage[:4]}"))


def run(text: str, arithmetic: Any = FLOAT64, each: Any = None, **more: Any) -> Interpreted:
    return interpret(program(text), INPUTS if each is None else each, arithmetic=arithmetic, **more)


# GLSL over the inputs, and the same as a formula.
Formula = Callable[..., Any]
FLOATS: Mapping[str, Formula] = {
    "a * b + a.wzyx - b / a": lambda a, b: a * b + a.wzyx - b / a,
    "-a * 0.1 + 1.0 / 8.0": lambda a, b: -a * 0.1 + 1.0 / 8.0,
    "mod(b, a) + fract(b) + floor(b) + ceil(b) + trunc(b)": lambda a, b: (
        g.mod(b, a) + g.fract(b) + g.floor(b) + g.ceil(b) + g.trunc(b)
    ),
    "abs(b) + sign(b) + min(a, b) + max(a, b)": lambda a, b: (
        g.abs(b) + g.sign(b) + g.min(a, b) + g.max(a, b)
    ),
    "clamp(b, 0.25, 0.75) + mix(a, b, a)": lambda a, b: g.clamp(b, 0.25, 0.75) + g.mix(a, b, a),
    "step(a, b) + smoothstep(0.25, 0.75, b)": lambda a, b: (
        g.step(a, b) + g.smoothstep(0.25, 0.75, b)
    ),
    "sqrt(a) + inversesqrt(a) + pow(a, b)": lambda a, b: g.sqrt(a) + g.inversesqrt(a) + g.pow(a, b),
    "exp(b) + exp2(b) + log(a) + log2(a)": lambda a, b: g.exp(b) + g.exp2(b) + g.log(a) + g.log2(a),
    "sin(b) + cos(b) + tan(a) + asin(a) + acos(a)": lambda a, b: (
        g.sin(b) + g.cos(b) + g.tan(a) + g.asin(a) + g.acos(a)
    ),
    "atan(b) + atan(b, a) + sinh(b) + cosh(b) + tanh(b)": lambda a, b: (
        g.atan(b) + g.atan(b, a) + g.sinh(b) + g.cosh(b) + g.tanh(b)
    ),
    "vec4(radians(b.x), degrees(b.y), dot(a, b), length(b))": lambda a, b: g.vec4(
        g.radians(b.x), g.degrees(b.y), g.dot(a, b), g.length(b)
    ),
    "vec4(cross(a.xyz, b.xyz), distance(a, b))": lambda a, b: g.vec4(
        g.cross(a.xyz, b.xyz), g.distance(a, b)
    ),
    "normalize(b) + reflect(a, b)": lambda a, b: g.normalize(b) + g.reflect(a, b),
    "faceforward(a, b, a.wzyx)": lambda a, b: g.faceforward(a, b, a.wzyx),
    "refract(normalize(b), normalize(a), 0.5)": lambda a, b: g.refract(
        g.normalize(b), g.normalize(a), 0.5
    ),
    "mat4(a, b, a.wzyx, b.yxwz) * a": lambda a, b: g.mul(g.mat4(a, b, a.wzyx, b.yxwz), a),
    "a * mat4(a, b, a.wzyx, b.yxwz)": lambda a, b: g.mul(
        g.transpose(g.mat4(a, b, a.wzyx, b.yxwz)), a
    ),
    "(mat4(a, b, b, a) * mat4(b, a, a, b))[1]": lambda a, b: g.matmul(
        g.mat4(a, b, b, a), g.mat4(b, a, a, b)
    )[..., 1],
    "(transpose(mat4(a, b, b, a)) * 2.0)[3] + outerProduct(a, b)[2]": lambda a, b: (
        (g.transpose(g.mat4(a, b, b, a)) * 2.0)[..., 3] + g.outerProduct(a, b)[..., 2]
    ),
    "vec4(determinant(mat2(a.xy, b.zw)), inverse(mat2(a.xy, b.zw))[1], 0.0)": lambda a, b: g.vec4(
        g.determinant(g.mat2(a.xy, b.zw)), g.inverse(g.mat2(a.xy, b.zw))[..., 1], 0.0
    ),
    "a.x < b.x ? a : b": lambda a, b: g.where(a.x < b.x, a, b),
    "mix(a, b, lessThan(a, b)) + vec4(any(equal(a, b)))": lambda a, b: g.where(a < b, b, a) + 0.0,
    "vec4(isnan(a.x) || isinf(b.x), a.x != b.x, !(a.x >= b.x), a.x > 0.5 ^^ b.x <= 0.0)": (
        lambda a, b: g.vec4(
            0.0,
            1.0,
            g.where(a.x >= b.x, 0.0, 1.0),
            g.where(g.notEqual(a.x > 0.5, b.x <= 0.0), 1.0, 0.0),
        )
    ),
}


@pytest.mark.parametrize("glsl", FLOATS)
def test_floats_are_what_the_formula_gives(glsl: str) -> None:
    text = DECLARED + f"void main() {{ color = {glsl}; }}"
    a, b = (INPUTS[name].astype(np.float64).view(sampling_vector()) for name in "ab")
    wanted = np.broadcast_to(FLOATS[glsl](a, b), (COUNT, 4))
    np.testing.assert_allclose(run(text).outputs["color"], wanted, rtol=1e-12, atol=1e-12)

    by_hand = FLOATS[glsl](*(Band.exact(INPUTS[name]) for name in "ab"))
    band = run(text, Bands()).outputs["color"]
    width, by_hand_width = band.hi - band.lo, np.broadcast_to(by_hand.hi - by_hand.lo, (COUNT, 4))
    assert (width <= by_hand_width * 1.05 + 1e-30).all()
    rounded = run(text, FLOAT32).outputs["color"]
    assert rounded.dtype == np.float32 and band.contains(rounded).all()
    assert band.contains(wanted.astype(np.float32)).all()


def sampling_vector() -> Any:
    from shaderlab.bands.bounds import Vector

    return Vector


INTEGERS: Mapping[str, Callable[[Integer, Integer], Any]] = {
    "n * n.wzyx + 7 - n": lambda n, m: n * n.wzyx + 7 - n,
    "n / 7 + abs(n) % 5": lambda n, m: n / 7 + g.abs(n) % 5,
    "-n & 0xFF | n << 3 ^ n >> 2": lambda n, m: (-n & 0xFF) | ((n << 3) ^ (n >> 2)),
    "ivec4(m >> 3u) + ivec4(m * 747796405u + 2891336453u)": lambda n, m: (
        (m >> 3).convert(False) + (m * 747796405 + 2891336453).convert(False)
    ),
    "ivec4(m / 7u % 5u) + ~n": lambda n, m: (m / 7 % 5).convert(False) + ~n,
    "min(n, 3) + max(n, n.wzyx) + clamp(n, -5, 5) + sign(n)": lambda n, m: (
        g.min(n, 3) + g.max(n, n.wzyx) + g.clamp(n, -5, 5) + g.sign(n)
    ),
    "ivec4(vec4(n) * 0.5) + ivec4(n.x > 3, n.y <= 3, n.z == 3, n.w != 3)": lambda n, m: (
        g.int(n.to_float() * 0.5)
        + g.ivec4(
            *(g.int(g.where(c, Integer(1), Integer(0)))
              for c in (n.x > 3, n.y <= 3, n.z == 3, n.w != 3))
        )
    ),
    "floatBitsToInt(intBitsToFloat((n & 0x7FFFFF) + 0x3F800000))": lambda n, m: (
        (n & 0x7FFFFF) + 0x3F800000
    ),
    "bitCount(n) + findLSB(n) + findMSB(n) + bitfieldReverse(n)": lambda n, m: (
        g.bitCount(n) + g.findLSB(n) + g.findMSB(n) + g.bitfieldReverse(n)
    ),
    "bitfieldInsert(n, n.wzyx, 3, 7) + bitfieldExtract(n, 2, 9)": lambda n, m: (
        g.bitfieldInsert(n, n.wzyx, 3, 7) + g.bitfieldExtract(n, 2, 9)
    ),
}  # fmt: skip


@pytest.mark.parametrize("glsl", INTEGERS)
@pytest.mark.parametrize("arithmetic", [FLOAT64, Bands()], ids=["float64", "band"])
def test_integers_are_exact(glsl: str, arithmetic: Any) -> None:
    text = DECLARED + f"void main() {{ whole = {glsl}; }}"
    result = interpret(program(text, version="430 core"), INPUTS, arithmetic=arithmetic)
    n, m = Integer(INPUTS["n"]), Integer(INPUTS["m"], unsigned=True)
    assert np.array_equal(result.outputs["whole"].lo, INTEGERS[glsl](n, m).lo)
    assert np.array_equal(result.outputs["whole"].hi, INTEGERS[glsl](n, m).lo)


FLOW = """
uniform float steps;
float twice(inout float x) { if (x > 0.9) return -1.0; x *= 2.0; return x + 1.0; }
void main() {
    float sum = 0.0;
    for (int i = 0; i < int(steps); ++i) {
        if (a.x > 0.5 && b.x > float(i) * 0.2 || a.y < 0.2) continue;
        sum += a.x;
        if (sum > 1.5) break;
    }
    float x = a.z;
    float got = twice(x);
    do { sum -= 0.3; } while (sum > b.y);
    switch (n.x & 3) { case 0: sum += 10.0; case 1: sum += 20.0; break; default: sum += 30.0; }
    if (b.z > 1.5) { if (a.w > 0.5) discard; sum = 0.0; }
    float table[3] = float[](1.0, 2.0, 4.0);
    table[n.y & 1] += 0.5;
    vec4 v = a; v[n.z & 3] = 7.0;
    color = vec4(sum, got, x * table[n.y & 1], v[2]);
}
"""


def flow_by_hand(i: int) -> list[float] | None:
    """The same program for one invocation, in Python."""
    a, b, n = (INPUTS[name][i].tolist() for name in "abn")
    total, x = 0.0, a[2]
    for k in range(5):
        if (a[0] > 0.5 and b[0] > k * 0.2) or a[1] < 0.2:
            continue
        total += a[0]
        if total > 1.5:
            break
    got = -1.0 if x > 0.9 else x * 2.0 + 1.0
    x = x if x > 0.9 else x * 2.0
    total -= 0.3
    while total > b[1]:
        total -= 0.3
    total += {0: 30.0, 1: 20.0}.get(n[0] & 3, 30.0)
    if b[2] > 1.5:
        if a[3] > 0.5:
            return None
        total = 0.0
    element = [1.0, 2.0][n[1] & 1] + 0.5
    return [total, got, x * element, 7.0 if n[2] & 3 == 2 else a[2]]


def test_control_flow_goes_its_own_way_for_each_invocation() -> None:
    bindings = Bindings(uniforms={"steps": np.array([5.0])})
    result = run(DECLARED + FLOW, bindings=bindings)
    by_hand = [flow_by_hand(i) for i in range(COUNT)]
    gone = np.array([values is None for values in by_hand])
    assert gone.any() and np.array_equal(result.discarded.all_true, gone)
    kept = np.array([values for values in by_hand if values is not None])
    np.testing.assert_allclose(result.outputs["color"][~gone], kept, rtol=1e-12, atol=1e-12)

    band = run(DECLARED + FLOW, Bands(), bindings=bindings)
    assert band.outputs["color"].contains(kept_rows(kept, gone)).all(axis=-1)[~gone].all()


@pytest.mark.parametrize(("seed", "worse"), [(0, False), (1, False), (2, True)])
def test_no_conforming_device_leaves_the_band(seed: int, worse: bool) -> None:
    """One that errs in every operation as much as it may; one that errs more does leave it."""
    device = Device(seed, "either")
    if worse:
        within = device.within_ulps
        device.within_ulps = lambda exact, ulps: within(exact, 4.0 * ulps)  # type: ignore[method-assign]
    bindings = Bindings(uniforms={"steps": np.array([5.0])})
    texts = (DECLARED + FLOW, DECLARED + "void main() { color = normalize(b) / a + exp(a * b); }")
    found = 0
    for text in texts:
        band = run(text, Bands(), bindings=bindings)
        theirs = run(text, Erring(device=device), bindings=bindings)
        kept = band.discarded.all_false & theirs.discarded.all_false
        found += outside(band.outputs["color"][kept], theirs.outputs["color"][kept])
    assert (found > 0) is worse


def test_the_adversary_rearranges_what_precise_forbids() -> None:
    text = DECLARED + "void main() { vec4 c = a - b; color = (c + b) * (c + a) + (b + c * a); }"
    theirs = run(text, Erring(device=Device(3, "either"))).outputs["color"]
    assert outside(run(text, Bands()).outputs["color"], theirs) == 0
    assert outside(run(text, Bands(Rules(rearrange=False))).outputs["color"], theirs) > 0


def kept_rows(kept: Any, gone: Any) -> Any:
    whole = np.zeros((COUNT, 4))
    whole[~gone] = kept
    return whole.astype(np.float32)


def test_an_invocation_that_a_band_cannot_decide_takes_both_sides() -> None:
    text = (
        DECLARED
        + """void main() {
        float x = sin(a.x), r = 0.0;
        if (x * x + cos(a.x) * cos(a.x) > 1.0) r = 1.0; else r = 2.0;
        if (x > 5.0) discard;
        if (cos(a.x) * cos(a.x) + x * x > 1.0) discard;
        color = vec4(r);
    }"""
    )
    result = run(text, Bands())
    band = result.outputs["color"]
    assert (band.lo == 1.0).all() and (band.hi == 2.0).all() and band.undecided.all()
    assert result.discarded.undecided.all()
    # The first line is the version's.
    assert {line: int(flags.sum()) for line, flags in result.undecided.items()} == {
        6: COUNT,
        8: COUNT,
    }


INTERFACE = """
struct Light { vec3 position; float falloff[2]; };
uniform Light lights[2]; uniform mat3 turn; uniform bool on; uniform int which;
layout(std140) uniform Camera { mat4 view; vec4 tint[2]; } camera;
layout(std140) uniform Plain { float gain; };
in Surface { vec3 normal; vec2 uv[2]; } surface;
out vec3 color; out vec2 rest[2];
void main() {
    color = turn * lights[which].position * lights[1].falloff[which] + surface.normal * gain;
    if (on) color += camera.view[3].xyz + camera.tint[1].rgb;
    rest[0] = surface.uv[1];
    rest[1] = gl_FragCoord.xy;
}
"""


def test_inputs_and_outputs_have_the_names_of_the_interface() -> None:
    some = {name: RNG.uniform(-1, 1, shape).astype(np.float32) for name, shape in {
        "lights[0].position": (3,), "lights[1].position": (3,), "turn": (3, 3),
        "lights[0].falloff": (2, 1), "lights[1].falloff": (2, 1), "Camera.view": (4, 4),
        "Camera.tint": (2, 4), "gain": (1,),
    }.items()}  # fmt: skip
    uniforms = {**some, "on": np.array([1]), "which": np.array([1])}
    each = {
        "Surface.normal": INPUTS["b"][:, :3],
        "Surface.uv[0]": INPUTS["a"][:, :2],
        "Surface.uv[1]": INPUTS["a"][:, 2:],
        "gl_FragCoord": INPUTS["b"],
    }
    result = interpret(program(INTERFACE), each, Bindings(uniforms=uniforms), FLOAT64)
    wide = {name: values.astype(np.float64) for name, values in some.items()}
    wanted = (
        wide["turn"] @ wide["lights[1].position"] * wide["lights[1].falloff"][1]
        + INPUTS["b"][:, :3].astype(np.float64) * wide["gain"]
        + wide["Camera.view"][:3, 3]
        + wide["Camera.tint"][1, :3]
    )
    np.testing.assert_allclose(result.outputs["color"], wanted, rtol=1e-12)
    np.testing.assert_array_equal(result.outputs["rest"][0], INPUTS["a"][:, 2:])
    np.testing.assert_array_equal(result.outputs["rest"][1], INPUTS["b"][:, :2])

    with pytest.raises(FormulaError, match=r"nothing is given for 'lights\[1\].position'"):
        interpret(program(INTERFACE), each, Bindings(uniforms={"turn": some["turn"], "which": [1]}))


def test_a_part_that_nothing_reads_needs_no_value_where_an_index_differs() -> None:
    text = """struct Light { vec3 color; float power; };
    uniform Light lights[2];
    uniform int k;
    out vec3 color;
    void main() { color = lights[k].color; }
    """
    colors = {"lights[0].color": np.array([[1.0, 2.0, 3.0]]), "lights[1].color": np.zeros((1, 3))}
    found = run(text, each={**colors, "k": np.array([[0], [1]])}, count=2)
    assert found.outputs["color"].tolist() == [[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]]


def test_a_vertex_stage() -> None:
    text = """in vec3 position; uniform mat4 model; out vec3 world;
    void main() { world = vec3(model * vec4(position, 1.0)) + float(gl_InstanceID);
                  gl_Position = vec4(world, 2.0); }"""
    model = RNG.uniform(-1, 1, (4, 4)).astype(np.float32)
    each = {"position": INPUTS["b"][:, :3], "gl_InstanceID": np.full((COUNT, 1), 3)}
    bindings = Bindings(uniforms={"model": model})
    result = interpret(program(text, "vertex"), each, bindings, FLOAT64)
    wanted = INPUTS["b"][:, :3].astype(np.float64) @ model[:3, :3].T.astype(np.float64)
    wanted = wanted + model[:3, 3] + 3.0
    np.testing.assert_allclose(result.outputs["world"], wanted, rtol=1e-12)
    np.testing.assert_allclose(result.outputs["gl_Position"][:, :3], wanted, rtol=1e-12)


def test_textures_are_read_as_sampling_reads_them() -> None:
    text = """in vec4 a; uniform sampler2D t; out vec4 color; out vec4 sized;
    void main() {
        color = texture(t, a.xy) + textureLod(t, a.zw, 0.0) + texelFetch(t, ivec2(a.xy * 7.0), 0)
              + textureOffset(t, a.xy, ivec2(1, -2)) + textureProj(t, vec3(a.xy, 2.0));
        if (a.x > 0.5) sized = texelFetch(t, ivec2((a.x - 0.5) * 15.9, 0), 0);
        else sized = vec4(textureSize(t, 0), 0, 0);
    }"""
    image = Texels(RNG.uniform(0, 1, (8, 8, 4)).astype(np.float32), ("linear",) * 2,
                   ("repeat",) * 2, (0.0,) * 4)  # fmt: skip
    bindings = Bindings(textures={"t": image})
    a = INPUTS["a"].astype(np.float64)
    s = sampling.Sampler(image)
    wanted = (
        sampling.texture(s, a[:, :2])
        + sampling.texture(s, a[:, 2:])
        + sampling.texelFetch(s, np.floor(a[:, :2] * 7.0))
        + sampling.textureOffset(s, a[:, :2], (1, -2))
        + sampling.textureProj(s, np.concatenate([a[:, :2], np.full((COUNT, 1), 2.0)], -1))
    )
    result = run(text, bindings=bindings)
    np.testing.assert_allclose(result.outputs["color"], wanted, rtol=1e-12)
    band = run(text, Bands(), bindings=bindings)
    assert band.outputs["color"].contains(wanted.astype(np.float32)).all()
    assert np.array_equal(
        result.outputs["sized"][a[:, 0] <= 0.5], [[8, 8, 0, 0]] * int((a[:, 0] <= 0.5).sum())
    )


def test_a_place_that_is_known_badly_gives_any_texel() -> None:
    text = """in vec4 a; uniform sampler2D t; out vec4 color;
    void main() { color = texture(t, vec2(sin(a.x) * 1000.0, 0.5)); }"""
    image = Texels(np.array([[[0.25], [0.5], [2.0]]], np.float32), ("nearest",) * 2,
                   ("repeat",) * 2, (0.0,) * 4)  # fmt: skip
    band = run(text, Bands(), bindings=Bindings(textures={"t": image})).outputs["color"]
    assert (band.lo[:, 0] <= 0.0).all() and (band.hi[:, 0] >= 2.0).all()
    assert (band.hi[:, 0] < 2.1).all() and not band.vacuous.any()


def test_derivatives_find_the_pixels_beside() -> None:
    y, x = np.mgrid[:4, :4].reshape(2, -1)
    each = {"at": (x * x + 3.0 * y)[:, None], "gl_FragCoord": np.stack([x + 0.5, y + 0.5], -1)}
    text = """in float at; out vec3 color;
    void main() { color = vec3(dFdx(at), dFdy(at), fwidth(at)); }"""
    result = run(text, each=each).outputs["color"]
    assert result[:4].tolist() == [[1, 3, 4], [1, 3, 4], [5, 3, 8], [5, 3, 8]]
    with pytest.raises(NotInterpretedError, match="dFdx without gl_FragCoord of each pixel"):
        run(text, each={"at": each["at"]})


def test_each_width_rounds_as_it_does() -> None:
    text = DECLARED + "void main() { color = vec4(a.x * a.y + 0.1); }"
    wide, single, half = (run(text, each_width).outputs["color"] for each_width in
                          (FLOAT64, FLOAT32, FLOAT16))  # fmt: skip
    a = INPUTS["a"]
    assert (single[:, 0] == a[:, 0] * a[:, 1] + np.float32(0.1)).all()
    h = a.astype(np.float16)
    assert (half[:, 0] == h[:, 0] * h[:, 1] + np.float16(0.1)).all()
    assert 0.0 < np.abs(wide - single).max() < 1e-6 < np.abs(wide - half).max() < 1e-2


def test_the_trace_names_what_each_line_stores() -> None:
    text = (
        DECLARED
        + """struct Light { vec3 position; };
    float half_of(float x) {
        return x * 0.5;
    }
    void main() {
        Light light;
        light.position.y = half_of(a.x);
        vec4 sum = vec4(0.0);
        if (a.x > 0.5)
            sum[n.x & 1] = 1.0;
        color = sum;
    }"""
    )
    seen: list[Stored] = []
    run(text, trace=lambda event: event.is_argument or seen.append(event))
    assert [(s.line, s.name, s.calls) for s in seen] == [
        (6, "half_of()", (10,)),
        (10, "light.position.y", ()),
        (11, "sum", ()),
        (13, "sum[?]", ()),
        (14, "color", ()),
    ]
    assert np.array_equal(seen[3].mask, INPUTS["a"][:, 0] > 0.5)
    np.testing.assert_array_equal(seen[0].value[:, 0], INPUTS["a"][:, 0].astype(np.float64) * 0.5)


def test_what_is_unknown_is_named_with_its_line() -> None:
    text = """in vec4 a; out vec4 color;
    void main() {
        color = vec4(interpolateAtCentroid(a));
    }"""
    message = r"not interpreted: GLSL's InterpolateAtCentroid at line 4$"
    with pytest.raises(NotInterpretedError, match=message):
        interpret(program(text, version="450 core"), INPUTS)
    with pytest.raises(NotInterpretedError, match="not interpreted: SPIR-V's FConvert at line 2"):
        interpret(program(
            "in vec4 a; out vec4 color; void main() { color = vec4(double(a.x)); }",
            version="450 core",
        ), INPUTS)  # fmt: skip


def test_a_loop_without_an_end_is_refused() -> None:
    text = (
        DECLARED
        + """void main() {
        float x = 1.0;
        while (x > 0.0)
            x += 1.0;
        color = vec4(x);
    }"""
    )
    with pytest.raises(NotInterpretedError, match="goes on after 4096 iterations at line 6"):
        run(text)


def test_wrong_bytes_and_wrong_shaders() -> None:
    with pytest.raises(ShaderError, match="not a SPIR-V module"):
        read(b"nothing of the kind")
    with pytest.raises(ShaderError, match="undeclared identifier"):
        program("void main() { float x = y; }")


def test_what_nothing_was_stored_to_may_be_anything() -> None:
    text = DECLARED + "void main() { float x; if (a.x > 2.0) x = 1.0; color = vec4(x, a.xyz); }"
    band = run(text, Bands()).outputs["color"]
    assert band.vacuous[:, 0].all() and not band.vacuous[:, 1:].any()


def test_rules_reach_the_bands() -> None:
    text = DECLARED + "void main() { color = sin(b * 4.0); }"
    assert run(text, Bands()).outputs["color"].vacuous.any()
    scaled = run(text, Bands(Rules(trig_outside="scaled"))).outputs["color"]
    assert not scaled.vacuous.any()
