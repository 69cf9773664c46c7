"""Checks of GLSL functions: each passes where it should, and fails with the place where not."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any, NamedTuple

import numpy as np
import pytest

from shaderlab import Texture, glsl
from shaderlab.errors import CallError, CaseError, FormulaError
from shaderlab.glslmath import (
    abs,
    array,
    bitCount,
    cos,
    dot,
    floor,
    int,
    mat2,
    sin,
    sqrt,
    vec2,
    vec3,
    vec4,
    where,
)  # fmt: skip
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.attenuation import attenuation
from shaderlab.reference.gamma import srgb_encode
from shaderlab.reference.tone_mapping import reinhard

SHADER = """
struct Light { float constant; float linear; float quadratic; };
float fades(float d, float c, float l, float q) { return 1.0 / (c + l * d + q * d * d); }
float attenuation(Light light, float distance) {
    return fades(distance, light.constant, light.linear, light.quadratic);
}
float steps(float d, float c, float l, float q) {
    return fades(d, c, l, q) * (d > 49.9 ? 1.01 : 1.0);
}
float encode(float c) { return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1.0 / 2.4) - 0.055; }
float decode(float c) { return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4); }
vec3 mapped(vec3 light) { return light / (1.0 + light); }
vec3 green(vec3 light) { return light / vec3(1.0 + light.x, 1.0 + light.x, 1.0 + light.z); }
float squared(float x) { return x * x; }
float cubed(float x) { return x * x * x; }
float limited(float x) { return clamp(x, 0.0, 1.0); }
float halved(float x) { return 0.5 * x; }
float less(float a, float b) { return a - b; }
float both(float a, float b) { return a * b + (a + b); }
float still(float x) { return 1.0 + 0.0 * x; }
float kept(float x) { if (x < 0.0) discard; return 2.0 * x; }
mat2 turned(float x) { return mat2(cos(x), sin(x), -sin(x), cos(x)); }
bool lit(float x) { return x > 0.5; }
int doubled(int n) { return n * 2; }
struct Hit { float t; vec3 normal; bool met; };
Hit sphere(vec3 eye, vec3 ray, float radius) {
    float b = dot(eye, ray), d = b * b - dot(eye, eye) + radius * radius, t = -b - sqrt(d);
    return Hit(t, (eye + t * ray) / radius, t > 0.0);
}
void halves(float x, out vec2 low, inout float high) { low = vec2(0.5 * x, x); high *= 0.25; }
float[3] powers(float x) { return float[3](x, x * x, x * x * x); }
vec2[2] corners(float x) { return vec2[2](vec2(x), vec2(x, 1.0)); }
uint[2] odds(uint n) { return uint[2](n | 1u, n * 3u); }
float sum(float x, int terms) {
    float found = 0.0;
    for (int i = 0; i < terms; ++i) found += x;
    return found;
}
const float TABLE[4] = float[](0.1, 0.7, 0.3, 0.9);
uniform vec2 kernel[3];
float chosen(float x) { return 0.3 * TABLE[int(floor(x * 4.0))]; }
vec2 weighed(int i, float x) { return kernel[i] * x; }
int permuted(int i) { const int p[4] = int[](3, 1, 0, 2); return p[p[i & 3]] / 2; }
struct Surface { sampler2D color; float gain; };
vec4 painted(sampler2D image, vec2 at) { return 0.5 * texture(image, at); }
vec4 shone(Surface surface, vec2 at) { return surface.gain * texture(surface.color, at); }
"""
EYES = np.random.default_rng(4).uniform((-0.5, -0.5, 4.0), (0.5, 0.5, 5.0), (64, 3))
SPHERE = EYES, (0.0, 0.0, -1.0), 1.0
LAMP = (1.0, 0.09, 0.032)
D = np.linspace(0.0, 50.0, 1001)
X = np.linspace(-2.0, 2.0, 41)
UNIT = np.linspace(0.001, 1.0, 301)


@pytest.fixture(scope="module")
def shader() -> glsl.Library:
    return glsl.load(SHADER, kernel=KERNEL)


def decoded(y: Any) -> Any:
    return glsl.load(SHADER).decode(y)


def fading(d: Any, constant: float, linear: float, quadratic: float) -> Any:
    return 1.0 / (constant + linear * d + quadratic * d * d)


def twice(x: Any) -> Any:
    return 2.0 * x


def twice_of_whole(n: Any) -> Any:
    return n * 2


def hit(eye: Any, ray: Any, radius: Any) -> dict[str, Any]:
    b = dot(eye, ray)
    t = -b - sqrt(b * b - dot(eye, eye) + radius * radius)
    return {"t": t, "normal": (eye + t * ray) / radius, "met": t > 0.0}


class Hit(NamedTuple):
    t: Any
    normal: Any
    met: Any


def turning(x: Any) -> Any:
    return mat2(cos(x), sin(x), -sin(x), cos(x))


def added(x: Any, terms: Any) -> Any:
    return functools.reduce(lambda so_far, _: so_far + x, range(terms), 0.0)


BITS = np.array([0, 5, 2**24 + 1, 2**32 - 1], np.uint32)

TABLE = array(0.1, 0.7, 0.3, 0.9)
FOURTHS = np.array([0.1, 0.3, 0.6, 0.9])
KERNEL = np.array([(0.1, 0.2), (0.3, 0.7), (0.9, 0.4)])
IMAGE = np.random.default_rng(5).random((4, 4, 4)).astype(np.float32)
PLACES = np.random.default_rng(6).random((64, 2))
SMOOTH = Texture(image=IMAGE, format="rgba32f", filter=("linear", "linear"))


def permuted(i: Any) -> Any:
    p = array(3, 1, 0, 2)
    return p[p[i & 3]] / 2


def shone(surface_color: Any, surface_gain: Any, at: Any) -> Any:
    return surface_gain * texture(surface_color, at)


PASS: list[tuple[str, Any, tuple[Any, ...]]] = [
    ("fades", attenuation, (D, *LAMP)),
    ("attenuation", attenuation, ({"constant": 1.0, "linear": 0.09, "quadratic": 0.032}, D)),
    ("encode", srgb_encode, (UNIT,)),
    ("mapped", reinhard, (np.random.default_rng(1).random((64, 3)) * 4.0,)),
    ("kept", twice, (X,)),
    ("doubled", twice_of_whole, (np.arange(-9, 9),)),
    ("sphere", hit, SPHERE),
    ("sphere", lambda eye, ray, radius: tuple(hit(eye, ray, radius).values()), SPHERE),
    ("sphere", lambda eye, ray, radius: Hit(**hit(eye, ray, radius)), SPHERE),
    ("halves", lambda x, high: (vec2(0.5 * x, x), 0.25 * high), (X, X)),
    ("turned", turning, (X,)),
    ("turned", lambda x: mat2(1.0), (0.0,)),
    ("powers", lambda x: [x, x * x, x * x * x], (X,)),
    ("powers", lambda x: vec3(x, x * x, x * x * x), (X,)),
    ("corners", lambda x: [x, vec2(x, 1.0)], (X,)),
    ("odds", lambda n: [n | 1, n * 3], (BITS,)),
    ("lit", lambda x: x > 0.5, (X,)),
    ("sum", added, (X, 3)),
    ("chosen", lambda x: 0.3 * TABLE[int(floor(x * 4.0))], (FOURTHS,)),
    ("chosen", lambda x: 0.3 * array(np.array(TABLE))[int(floor(x * 4.0))], (FOURTHS,)),
    ("weighed", lambda i, x, kernel: kernel[i] * x, (np.arange(41) % 3, X)),
    ("permuted", permuted, (np.arange(-4, 9),)),
    ("painted", lambda image, at: 0.5 * texture(image, at), (IMAGE, PLACES)),
    ("painted", lambda map, uv: 0.5 * texture(map, uv), (SMOOTH, PLACES)),
    ("painted", lambda uv: vec4(0.5), (np.ones((2, 2, 4)), PLACES)),
    ("shone", shone, ({"color": IMAGE, "gain": 0.7}, PLACES)),
    ("fades", glsl.monotone("d", direction="decreasing", strict=True), (D, *LAMP)),
    ("fades", glsl.monotone("d", direction="decreasing"), (D[::-1], *LAMP)),
    ("fades", glsl.bounded(0.0, 1.0), (D, *LAMP)),
    ("mapped", glsl.bounded(0.0, [1.0, 0.5, 1.0]), ([[2.0, 1.0, 2.0]],)),
    ("encode", glsl.inverse(decoded, ulp=64), (UNIT,)),
    ("squared", glsl.even("x"), (X,)),
    ("cubed", glsl.odd("x"), (X,)),
    ("limited", glsl.idempotent(), (X,)),
    ("both", glsl.symmetric(("a", "b")), (X, X[::-1])),
    ("fades", glsl.same_as(fading, ulp=2), (D, *LAMP)),
    ("fades", glsl.table([1.0, 0.8913, 0.012], digits=3), ([0.0, 1.0, 49.3], *LAMP)),
    ("turned", glsl.table([[1.0, 0.0], [0.0, 1.0]]), (0.0,)),
    ("lit", glsl.table([False, True]), ([0.0, 1.0],)),
]  # fmt: skip


@pytest.mark.parametrize(("name", "law", "arguments"), PASS)
def test_a_right_function_passes(
    shader: glsl.Library, name: str, law: Any, arguments: tuple[Any, ...]
) -> None:
    shader[name].check(law, *arguments)


FAIL: list[tuple[str, Any, tuple[Any, ...], list[str]]] = [
    (
        "steps", attenuation, (D, *LAMP),
        ["float steps(float d,", "2 of 1001 values lie outside", "measured   0.0118",
         "band       [0.", "ulp", "distance = ", "light_linear = 0.0900000036",
         "text:7", "attenuation.py:"],
    ),
    ("green", reinhard, ([[1.0, 2.0, 3.0]],), ["component g", "light = (1, 2, 3)"]),
    (
        "sphere", lambda eye, ray, radius: {**hit(eye, ray, radius), "normal": -ray}, SPHERE,
        ["sphere.normal:", "192 of 192 values", "eye = ("],
    ),
    ("sphere", lambda eye, ray, radius: {**hit(eye, ray, radius), "met": False}, SPHERE,
     ["sphere.met:", "1 from the exact value"]),
    ("halves", lambda x, high: (vec2(0.5 * x, x), 0.5 * high), (X, X), ["halves.high:"]),
    ("turned", lambda x: mat2(cos(x), -sin(x), sin(x), cos(x)), (X,), ["80 of 164 values"]),
    ("powers", lambda x: [x, x * x, x], (X,), ["powers[2]:"]),
    ("odds", lambda n: [n | 1, n], (BITS,), ["odds[1]:", "3 of 4 values"]),
    ("chosen", lambda x: 0.3 * array(0.1, 0.7, 0.3, 0.91)[int(floor(x * 4.0))], (FOURTHS,),
     ["1 of 4 values", "x = 0.899999976"]),
    ("chosen", lambda x: 0.3 * TABLE[int(floor(x * 4.0)) + 1], ([0.9],), ["anything"]),
    ("weighed", lambda i, x, kernel: kernel[2 - i] * x, (np.arange(3), X[:3]), ["4 of 6 values"]),
    ("permuted", lambda i: permuted(i + 1), (np.arange(4),), ["of 4 values"]),
    ("painted", lambda image, at: 0.5 * texture(image, at.yx), (IMAGE, PLACES), ["of 256 values"]),
    ("shone", lambda surface_color, at: texture(surface_color, at),
     ({"color": IMAGE, "gain": 0.7}, PLACES), ["256 of 256 values"]),
    ("lit", lambda x: x > 1.0, (X,), ["5 of 41 values"]),
    ("steps", glsl.monotone("d", direction="decreasing"), (D, *LAMP), ["of 1 of 1001", "d = 49.9"]),
    ("still", glsl.monotone("x"), (X,), ["could hardly fail: it is the same at all values"]),
    ("squared", glsl.bounded(0.0, 3.0), (X,), ["measured   4", "[0, 3]", "x = -2"]),
    ("squared", glsl.bounded(low=0.0), ([1.0, np.nan],), ["measured   nan"]),
    ("squared", glsl.odd("x"), (X,), ["odd does not hold", "x = -"]),
    ("cubed", glsl.even("x"), (X,), ["even does not hold"]),
    ("cubed", glsl.odd("x"), ([0.0],), ["could hardly fail: x is 0"]),
    ("halved", glsl.idempotent(), (X,), ["measured   -0.4", "reference  -0.9"]),
    ("less", glsl.symmetric(("a", "b")), (X, X[::-1]), ["a = -1.8", "b = 1.8"]),
    ("both", glsl.symmetric(("a", "b")), (X, X), ["a and b are equal"]),
    ("encode", glsl.inverse(np.sqrt), (UNIT,), ["inverse does not hold"]),
    ("steps", glsl.same_as(fading, ulp=2), (D, *LAMP), ["sameas does not hold of 2 of 1001"]),
    ("fades", glsl.table([1.0, 0.9], digits=2), ([0.0, 1.0], *LAMP), ["reference  0.9"]),
    ("kept", glsl.bounded(0.0), ([-1.0, -2.0],), ["nothing was judged"]),
    ("squared", glsl.bounded(0.0), (np.zeros(0),), ["nothing was judged"]),
    ("squared", lambda x: x * x, (np.zeros(0),), ["nothing was judged"]),
]  # fmt: skip


@pytest.mark.parametrize(("name", "law", "arguments", "says"), FAIL)
def test_a_wrong_one_fails_and_says_where(
    shader: glsl.Library, name: str, law: Any, arguments: tuple[Any, ...], says: list[str]
) -> None:
    with pytest.raises(AssertionError) as failure:
        shader[name].check(law, *arguments)
    for part in says:
        assert part in str(failure.value), str(failure.value)


@pytest.mark.parametrize(
    ("name", "law", "arguments", "says"),
    [
        ("fades", srgb_encode, (D, *LAMP), "srgb_encode takes linear; fades gets d, c, l, q"),
        ("sphere", glsl.bounded(0.0), SPHERE, "a law of one value; sphere returns t, normal, met"),
        ("fades", glsl.monotone("x"), (D, *LAMP), "gets no numbers named 'x'"),
        ("less", glsl.monotone("a"), (np.zeros((2, 2)), X[:2]), "give it values along an axis"),
        ("squared", glsl.table([1.0]), (X,), "has shape (1,), the function returns (41,)"),
    ],
)
def test_a_check_that_makes_no_sense_is_refused(
    shader: glsl.Library, name: str, law: Any, arguments: tuple[Any, ...], says: str
) -> None:
    with pytest.raises(CallError) as error:
        shader[name].check(law, *arguments)
    assert says in str(error.value)


@pytest.mark.parametrize(
    ("name", "reference", "arguments", "says"),
    [
        ("sphere", lambda eye, ray, radius: eye, SPHERE, "gives one value, not t, normal, met"),
        ("sphere", lambda eye, ray, radius: {"t": 1.0}, SPHERE, "gives dict of 1, not t, nor"),
        ("halves", lambda x, high: (x,), (X, X), 'return {"low": …, "high": …}, or a tuple'),
        ("turned", lambda x: x, (X,), "gives shape (41, 1) for a mat2"),
        ("powers", lambda x: [x, x], (X,), "gives list of 2, not [0], [1], [2]"),
        ("sum", added, (X, np.arange(41)), "differ from value to value"),
        ("turned", lambda x: mat2(x, x, x), (X,), "mat2 of 3 components in 3 arguments"),
        ("turned", lambda x: mat2(1.0) @ vec2(x, x), (X,), "glslmath.mul(m, v)"),
        ("turned", lambda x: mat2(1.0) * vec2(x, x), (X,), "glslmath.mul(m, v)"),
        ("permuted", lambda i: np.arange(4)[i], (np.arange(4),), "glslmath.array(table)[i]"),
        ("permuted", lambda i: [3, 1, 0, 2][i], (np.arange(4),), "glslmath.array(table)[i]"),
        ("permuted", lambda i: i & where(i < 1, 2, 3), (np.arange(4),), "glslmath.int(x)"),
        ("permuted", lambda i: where(i < 1, 2, 3) ^ i, (np.arange(4),), "glslmath.int(x)"),
        ("permuted", lambda i: i + (6 & abs(-2)), (np.arange(4),), "glslmath.int(x)"),
        ("permuted", lambda i: bitCount(where(i < 1, 2, 3)), (np.arange(4),), "glslmath.int(x)"),
        ("permuted", lambda i: where(i < 1, 2, 3) | 4, (np.arange(4),), "glslmath.int(x)"),
        ("chosen", lambda x: TABLE[x], (FOURTHS,), "index by int(x)"),
        ("painted", lambda image, at: texture(image, at),
         (dataclasses.replace(SMOOTH, mipmaps=True), PLACES), "can't read mipmaps"),
        ("painted", lambda map, uv: texture(map, uv),
         (dataclasses.replace(SMOOTH, mipmaps=True), PLACES), "can't read mipmaps"),
    ],
)  # fmt: skip
def test_a_reference_of_other_parts_is_told_what_to_give(
    shader: glsl.Library, name: str, reference: Any, arguments: tuple[Any, ...], says: str
) -> None:
    with pytest.raises((CallError, FormulaError)) as error:
        shader[name].check(reference, *arguments)
    assert says in str(error.value)


def test_bounds_are_given_and_references_are_formulas(shader: glsl.Library) -> None:
    with pytest.raises(CaseError, match="give low, high or both"):
        glsl.bounded()
    with pytest.raises(FormulaError, match="glslmath"):
        shader.squared.check(lambda x: np.exp(x), X)
