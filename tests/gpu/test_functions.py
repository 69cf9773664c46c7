"""GLSL functions called from Python: what goes in, what comes out, what is refused."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import Texture, glsl
from shaderlab.errors import CallError, ShaderError, ShaderlabError
from shaderlab.functions.evaluation import get_caller

KINDS = """
struct Light { vec3 color; float power; };
struct Lamp { Light light; bool on; };
const int COUNT = 2;
uniform float gain;
uniform Lights { vec3 sky; float suns[COUNT + 1]; };
uniform float bias = 0.5;
in vec2 uv;
float plain(float x) { return 2.0 * x; }
vec3 over(vec3 v) { return v + 1.0; }
float over(float x) { return x - 1.0; }
int over(int n) { return n * 10; }
vec3 turned(mat3 m, vec3 v) { return m * v; }
mat2x3 made(vec2 v) { return mat2x3(v, 1.0, 2.0, 3.0, 4.0); }
void parts(in float x, out vec2 both, inout int n) { both = vec2(x, -x); n += 1; }
float twin(float x, out float result) { result = 2.0 * x; return x; }
float written(float x, out bool positive) { positive = x > 0.0; return abs(x); }
uint bits(uint n) { return n >> 1u; }
Lamp lit(Lamp lamp, float by) { lamp.light.power *= by; lamp.on = !lamp.on; return lamp; }
float total(Light lights[COUNT], float weights[3]) {
    return lights[0].power + lights[1].power + weights[0] + weights[1] + weights[2];
}
float[3] thrice(float x) { return float[3](x, x + 1.0, x + 2.0); }
float globals(float x) { return gain * x + bias + uv.x + sky.z + suns[2]; }
vec4 sampled(sampler2D map, vec2 at) { return textureLod(map, at, 0.0); }
float kept(float x) { if (x < 0.0) discard; return sqrt(x); }
vec2 slopes(float x) { return vec2(dFdx(x), dFdy(x)); }
vec2 pixel(float x) { return gl_FragCoord.xy + 0.0 * x; }
float seen = 1.0;
float remembered(float x) { seen += 1.0; return x + seen; }
float big(float x[100]) { float s = 0.0; for (int i = 0; i < 100; i++) s += x[i]; return s; }
"""


@pytest.fixture(scope="module")
def kinds() -> glsl.Library:
    return glsl.load(KINDS)


def test_scalars_stay_scalars_and_arrays_broadcast(kinds: glsl.Library) -> None:
    value = kinds.plain(1.5)
    assert value == 3.0 and isinstance(value, np.float32)
    assert kinds.plain([1, 2]).tolist() == [2.0, 4.0]
    grid = kinds.turned(np.eye(3), np.zeros((4, 1, 3)) + np.arange(5)[:, None])
    assert grid.shape == (4, 5, 3) and (grid[2, 3] == 3.0).all()
    assert kinds.plain(np.zeros((0, 2))).shape == (0, 2)


def test_many_values_are_those_of_few(kinds: glsl.Library) -> None:
    x = np.arange((1 << 17) + 3, dtype=np.float32).reshape(-1, 7)
    found = kinds.plain(x)
    assert found.shape == x.shape and (found == 2.0 * x).all()
    turned = kinds.turned(np.eye(3), x[:-2].reshape(-1, 3))
    assert (turned.reshape(-1) == x[:-2].reshape(-1)).all()
    with pytest.raises(CallError, match="elements are too many"):
        kinds.plain(np.broadcast_to(np.float32(1.0), (1 << 27,)))


def test_overloads_follow_the_arguments(kinds: glsl.Library) -> None:
    assert kinds.over(3.0) == 2.0
    assert kinds.over(3) == 30 and kinds.over(3).dtype == np.int32
    assert kinds.over([1.0, 2.0, 3.0]).tolist() == [2.0, 3.0, 4.0]
    assert kinds.over["float"]([1.0, 2.0, 3.0]).tolist() == [0.0, 1.0, 2.0]
    assert kinds.over([1.0, 2.0]).tolist() == [0.0, 1.0]


def test_overloads_of_integers_follow_their_sign() -> None:
    text = "float f(float x) { return x; } int f(int x) { return x * 2; }"
    text += "uint f(uint x) { return x ^ 7u; } bool f(bool b) { return !b; }"
    f = glsl.load(f"#version 330 core\n{text}").f
    assert f(3) == 6 and f(np.int32(-3)) == -6 and f(True) == np.False_ and f(3.0) == 3.0
    assert f(np.arange(3)).tolist() == [0, 2, 4]
    assert f(np.arange(3, dtype=np.uint32)).tolist() == [7, 6, 5] and f(np.uint8(3)) == 4


def test_an_overload_without_a_parameter_is_called_before_one_that_writes_it() -> None:
    text = "float f(float x, out float slope) { slope = 2.0; return x * 2.0; } float f(float x) "
    library = glsl.load(f"#version 330 core\n{text}{{ float slope; return f(x, slope) + 1.0; }}")
    assert library.f(3.0) == 7.0
    assert len(library.f["float, float"](3.0)) == 2


def test_matrices_are_rows_and_columns(kinds: glsl.Library) -> None:
    m, v = np.arange(9.0).reshape(3, 3), np.array([1.0, 2.0, 3.0])
    assert kinds.turned(m, v).tolist() == (m @ v).tolist()
    assert kinds.made([5.0, 6.0]).tolist() == [[5.0, 2.0], [6.0, 3.0], [1.0, 4.0]]


def test_what_is_written_to_parameters_comes_back(kinds: glsl.Library) -> None:
    both, n = kinds.parts([1.0, 2.0], 5)
    assert both.tolist() == [[1.0, -1.0], [2.0, -2.0]] and n.tolist() == [6, 6]
    found = kinds.written(-2.0)
    assert found.result == 2.0 and not found.positive and found.positive.dtype == bool
    assert kinds.twin(3.0)._asdict() == {"returned": 3.0, "result": 6.0}
    assert kinds.bits(2**32 - 1) == 2**31 - 1


def test_structs_are_mappings_and_arrays_have_an_axis(kinds: glsl.Library) -> None:
    lamp = {"light": {"color": [1, 2, 3], "power": [4.0, 5.0]}, "on": True}
    found = kinds.lit(lamp, by=2.0)
    assert found["light"]["power"].tolist() == [8.0, 10.0] and not found["on"].any()
    assert found["light"]["color"].tolist() == [[1.0, 2.0, 3.0]] * 2
    lights = [{"color": [0, 0, 0], "power": n} for n in (1.0, 2.0)]
    assert kinds.total(lights, [1.0, 1.0, 1.0]) == 6.0
    assert kinds.thrice([0.0, 10.0]).tolist() == [[0.0, 1.0, 2.0], [10.0, 11.0, 12.0]]
    assert kinds.big(np.ones(100)) == 100.0
    assert kinds.big(np.ones((7, 100))).tolist() == [100.0] * 7


def test_globals_are_given_by_name(kinds: glsl.Library) -> None:
    given = {"uv": [[1.0, 0.0], [2.0, 0.0]], "sky": [0, 0, 100], "suns": [0, 0, 1000]}
    assert kinds.globals(3.0, gain=10.0, **given).tolist() == [1131.5, 1132.5]
    assert kinds.globals(3.0, gain=10.0, bias=0.0, **given).tolist() == [1131.0, 1132.0]
    assert glsl.load(KINDS, gain=1.0, **given).globals(3.0).tolist() == [1104.5, 1105.5]


def test_samplers_take_arrays_and_textures(kinds: glsl.Library) -> None:
    image = np.arange(16, dtype=np.float32).reshape(2, 2, 4)
    places = [[0.25, 0.25], [0.75, 0.75]]
    assert kinds.sampled(image, places).tolist() == [[0, 1, 2, 3], [12, 13, 14, 15]]
    texture = Texture(image=image, filter=("linear", "linear"))
    assert kinds.sampled(texture, [0.5, 0.5]).tolist() == [6.0, 7.0, 8.0, 9.0]


def test_samplers_of_integers_take_whole_numbers_and_others_are_named() -> None:
    library = glsl.load("""#version 330 core
    ivec4 signed_at(isampler2D map, ivec2 p) { return texelFetch(map, p, 0); }
    uvec4 unsigned_at(usampler2D map, ivec2 p) { return texelFetch(map, p, 0); }
    vec4 deep(sampler3D map) { return texture(map, vec3(0.5)); }
    uniform samplerBuffer numbers;
    vec4 number(int n) { return texelFetch(numbers, n); }
    """)
    assert library.signed_at(np.array([[-1, 2]]), (0, 0)).tolist() == [-1, 0, 0, 1]
    assert library.unsigned_at(np.array([[1, 2]]), (1, 0)).tolist() == [2, 0, 0, 1]
    with pytest.raises(CallError, match="map is isampler2D: it takes whole numbers"):
        library.signed_at(np.ones((2, 2)), (0, 0))
    with pytest.raises(CallError, match="deep can't be called: map is a sampler3D, of which the"):
        library.deep(np.ones((2, 2, 2, 4)))
    with pytest.raises(CallError, match="number can't be called: reads samplerBuffer numbers"):
        library.number(0)


def test_functions_of_the_fragment_stage(kinds: glsl.Library) -> None:
    kept = kinds.kept([-1.0, 4.0])
    assert kept.mask.tolist() == [True, False] and kept[1] == 2.0
    assert kinds.kept(-1.0) is np.ma.masked or kinds.kept(-1.0).mask
    x = 3.0 * np.arange(6)[:, None] + np.arange(4)
    assert kinds.slopes(x)[..., 0].tolist() == np.ones((6, 4)).tolist()
    assert (kinds.slopes(x)[..., 1] == 3.0).all()
    assert kinds.pixel(np.zeros((2, 3)))[1, 2].tolist() == [2.5, 1.5]


def test_a_call_leaves_nothing_to_the_next_element(kinds: glsl.Library) -> None:
    assert (kinds.remembered(np.zeros(1 << 15)) == 2.0).all()


@pytest.mark.parametrize(
    ("name", "arguments", "says"),
    [
        ("plain", ["one"], "plain: x is float; given was str 'one'"),
        ("plain", [1j], "x is float; given was complex 1j"),
        ("plain", [1.0, 2.0], "takes 1 arguments; given were 2"),
        ("plain", [], "float x is missing"),
        (
            "turned",
            [np.eye(3), np.zeros((5, 2))],
            "v is vec3; given was an array of float64, shape",
        ),
        ("turned", [np.zeros((2, 3, 3)), np.zeros((5, 3))], "do not broadcast: m (2,), v (5,)"),
        ("bits", [-1], "n: uint can't hold -1"),
        ("bits", [0.5], "n is uint; given was float 0.5"),
        ("lit", [{"light": {}, "on": True}, 1.0], "lamp.light: Light lacks color, power"),
        ("lit", [3.0, 1.0], "lamp is Lamp; given was float 3.0"),
        ("total", [[{}], [1, 1, 1]], "give a sequence of 2 values"),
        ("globals", [1.0], "globals reads float gain, which is not given"),
        ("sampled", ["no.png", [0, 0]], "map is sampler2D; given was str"),
        ("over", ["x"], "no overload fits"),
    ],
)
def test_errors_name_the_parameter_its_type_and_what_was_given(
    kinds: glsl.Library, name: str, arguments: list[Any], says: str
) -> None:
    with pytest.raises(CallError) as error:
        kinds[name](*arguments)
    assert says in str(error.value)


def test_a_name_that_is_not_there(kinds: glsl.Library) -> None:
    with pytest.raises(AttributeError, match="did you mean plain"):
        _ = kinds.plane
    with pytest.raises(CallError, match="takes no 'y'"):
        kinds.plain(y=1.0)


DIALECTS = {
    "a.frag": """#version 300 es
precision highp float;
uniform float time;
in vec2 uv;
out vec4 color;
float one(float x);
float f(float x) { return x * time + one(x); }
float one(float x) { return x / x; }
void main() { color = vec4(f(uv.x)); }
""",
    "b.frag": """#version 460
#extension GL_ARB_separate_shader_objects : require
layout(origin_upper_left) in vec4 gl_FragCoord;
layout(set = 0, binding = 1) uniform sampler2D map;
layout(push_constant) uniform Push { float time; int count; } push;
layout(constant_id = 3) const int ROUNDS = 2;
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;
float f(float x) { return x * push.time + float(ROUNDS) * 0.5 * texture(map, vec2(0.5)).x; }
void main() { color = vec4(f(uv.x)); }
""",
    "c.vert": """#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 model;
uniform float time;
float f(float x) { return x * time + position.x; }
void main() { gl_Position = model * vec4(position, f(1.0)); }
""",
    "d.comp": """#version 430
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Data { float values[]; };
uniform float time;
float f(float x) { return x * time + float(gl_GlobalInvocationID.x); }
float g(float x) { return values[0]; }
layout(rgba8) uniform image2D picture;
vec4 h(ivec2 place) { return imageLoad(picture, place); }
double i(double x) { return x; }
float j(float x) { barrier(); return x; }
void main() { values[gl_GlobalInvocationID.x] = f(1.0); }
""",
    "e.glsl": """#pragma once
#include "lib/common.glsl"
float f(float x) { return TWICE(x) + texture2D(map, vec2(0.5)).x; }
""",
    "lib/common.glsl": """
#define TWICE(x) ((x) * time)
uniform float time;
uniform sampler2D map;
""",
    "toy.frag": """
float f(float x) { return x * iTime + texture(iChannel0, vec2(0.5)).x; }
void mainImage(out vec4 fragColor, in vec2 fragCoord) {
    fragColor = vec4(fragCoord / iResolution.xy, f(1.0), 1.0);
}
""",
}  # fmt: skip
ONE = np.ones((1, 1, 4))
GIVEN: dict[str, dict[str, Any]] = {
    "a.frag": {"time": 2.0},
    "b.frag": {"push": {"time": 2.0, "count": 1}, "map": ONE},
    "c.vert": {"time": 2.0, "position": [1.0, 0.0, 0.0]},
    "d.comp": {"time": 2.0, "gl_GlobalInvocationID": [1, 0, 0]},
    "e.glsl": {"time": 2.0, "map": ONE},
    "toy.frag": {"iTime": 2.0, "iChannel0": ONE},
}


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tree")
    for name, text in DIALECTS.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    return folder


@pytest.mark.parametrize("name", GIVEN)
def test_every_dialect(tree: Path, name: str) -> None:
    assert glsl.load(tree / name).f(3.0, **GIVEN[name]) == 7.0


def test_a_file_without_a_version_has_old_names_and_new_functions() -> None:
    library = glsl.load("""
        float old(float x) { float sample = x; return sample; }
        float late(float x) { return fma(x, 2.0, 1.0); }
    """)
    assert library.old(2.0) == 2.0
    if os.environ.get("SHADERLAB_DRIVER") != "softpipe":  # which has no newer ones
        assert library.late(2.0) == 5.0


def test_shadertoys_image(tree: Path) -> None:
    toy = glsl.load(tree / "toy.frag", iResolution=[4.0, 2.0, 1.0], iTime=0.0, iChannel0=ONE)
    assert toy.mainImage([[1.0, 1.0], [4.0, 2.0]]).tolist() == [[0.25, 0.5, 1, 1], [1, 1, 1, 1]]


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("g", "reads or writes the storage block Data"),
        ("h", "reads image2D picture"),
        ("i", "result is a double"),
        ("j", "uses barrier, of another stage"),
    ],
)
def test_what_can_not_be_called_says_why(tree: Path, name: str, why: str) -> None:
    with pytest.raises(CallError, match=f"{name} can't be called: {why}"):
        glsl.load(tree / "d.comp")[name](1)


def test_a_function_that_does_not_compile_fails_at_its_line(tmp_path: Path) -> None:
    file = tmp_path / "wrong.glsl"
    file.write_text("float good(float x) { return x; }\n\nfloat bad(float x) { return y; }\n")
    library = glsl.load(file)
    assert library.good(1.0) == 1.0
    with pytest.raises(ShaderError, match=r"wrong.glsl:3: 'y'"):
        library.bad(1.0)
    file.write_text("float open(float x) {\n")
    with pytest.raises(ShaderError, match=r"wrong.glsl:1: '{' is never closed"):
        dir(glsl.load(file))


def test_files_are_found_beside_the_test_then_above_then_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder in ("game/.git", "game/tests", "game/shaders", "here"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "game" / "shaders" / "a.glsl").write_text("float f(float x) { return 1.0; }")
    (tmp_path / "game" / "tests" / "b.glsl").write_text("float f(float x) { return 2.0; }")
    (tmp_path / "here" / "c.glsl").write_text("float f(float x) { return 3.0; }")
    monkeypatch.chdir(tmp_path / "here")
    names = {"glsl": glsl, "__file__": str(tmp_path / "game" / "tests" / "test_a.py")}
    for name, value in (("shaders/a.glsl", 1.0), ("b.glsl", 2.0), ("c.glsl", 3.0)):
        assert eval(f"glsl.load({name!r}).f(0.0)", names) == value
    with pytest.raises(ShaderError, match="no such shader file in"):
        eval("glsl.load('d.glsl')", names)


# Mesa ends a loop of its own accord after 65535 rounds, which takes long for many elements.
ENDLESS = """
float endless(float x) { while (x < 2.0) x = fract(x * 1.5 + .1); return x; }
float good(float x) { return x; }
"""


class Hurrying:
    """A request for one that has no more time: so no test waits for a time limit."""

    def __init__(self, request: Any) -> None:
        self.request = request

    def perform(self, worker: Any) -> Any:
        worker.restart_limit(0.3)
        return self.request.perform(worker)


@pytest.mark.skipif(not hasattr(os, "memfd_create"), reason="signals and limits of Linux")
def test_a_hang_costs_one_call(monkeypatch: pytest.MonkeyPatch) -> None:
    library = glsl.load(ENDLESS)
    assert library.good(1.0) == 1.0
    perform = get_caller().perform
    with monkeypatch.context() as patch:
        patch.setattr(
            get_caller(), "perform", lambda request, what: perform(Hurrying(request), what)
        )
        with pytest.raises(CallError, match=r"endless of text: took longer than 0.3 s"):
            library.endless(np.zeros(1 << 21))
    assert library.good(1.0) == 1.0


@pytest.mark.parametrize(("returned", "given"), [("x", "a word"), ("nothing", 0.5)])
def test_an_error_shows_the_tests_own_line(returned: str, given: Any) -> None:
    """Not the way that it took through the lab, of which a test's author knows nothing."""
    f = glsl.load(f"float f(float x) {{ return {returned}; }}\n").f
    for call in (f, lambda value: f.check(glsl.monotone("x"), value)):
        with pytest.raises(ShaderlabError) as caught:
            call(given)
        inside = [entry for entry in caught.traceback if entry.path != Path(__file__)]
        assert [entry.frame.f_locals.get("__tracebackhide__") for entry in inside] == [True]
