"""Public constructors given what they do not take: one sentence that names the argument."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import shaderlab
from shaderlab import (
    Blend,
    Case,
    Cell,
    CubeTexture,
    Depth,
    Draw,
    Erratum,
    Mesh,
    Output,
    Pass,
    Pixel,
    Ramp,
    State,
    Stencil,
    Target,
    Texture,
    Texture3D,
    TextureArray,
    UniformBuffer,
    Variant,
    across,
    any_order,
    attribute_layout,
    block_layout,
    boundaries,
    bounded,
    compile_fails,
    compute,
    computed,
    coverage,
    even,
    exact,
    formula,
    fullscreen,
    gl_call,
    gl_error,
    inactive_uniforms,
    measure,
    mesh_pass,
    monotone,
    odd,
    query,
    reading,
    refused,
    sweep,
    symmetric,
    up,
    value,
)
from shaderlab.engine.catalogue import load_case
from shaderlab.errors import CaseError, ShaderlabError
from shaderlab.model.scene import flatten_structures


def law(x: Any) -> Any:
    return x


PICTURE = np.zeros((2, 2, 4))
TEXTURE = Texture(image=PICTURE)
BLOCK = UniformBuffer(values={"x": 1.0})
MESH = Mesh(attributes={"p": np.zeros((3, 2))})
PASSES = fullscreen("a.frag")
# Arguments that each constructor takes.
RIGHT: dict[Callable[..., Any], dict[str, Any]] = {
    Blend: {"source": "one", "constant": (0, 0, 0, 0)},
    Case: {"title": "t", "passes": PASSES, "expect": [formula("c", law)], "variants": [],
           "targets": ["glsl"], "picture": "c", "section": "1", "math": "x", "errata": []},
    Cell: {"column": 0, "row": 0, "columns": 1, "rows": 1},
    CubeTexture: {"faces": [PICTURE] * 6, "seamless": True},
    Depth: {"func": "less", "write": True},
    Draw: {"fragment": "a.frag", "vertex": "a.vert", "mesh": MESH, "uniforms": {"u": 1.0},
           "textures": {}, "blocks": {}, "instances": 1, "state": State()},
    Erratum: {"says": "a", "truth": "b", "proof": "c"},
    Mesh: {"attributes": {"p": [[0.0, 1.0]]}, "indices": [0], "primitive": "patches",
           "patch_vertices": 4},
    Output: {"path": "a.b", "mipmaps": True, "filter": ("nearest", "nearest")},
    Pass: {"draws": [PASSES[0].draws[0]], "name": "a", "target": Target()},
    Pixel: {"x": 0, "y": 0},
    Ramp: {"origin": 0.0, "dx": (1.0, 2.0), "dy": 0.0},
    State: {"depth": Depth(), "cull": "back", "viewport": (0, 0, 1, 1), "point_size": 2.0},
    Stencil: {"func": "always", "reference": 1, "mask": 255},
    Target: {"size": (2, 2), "colors": {"c": "rgba8"}, "samples": 4, "clear": (0, 0, 0, 0),
             "clear_depth": 1.0, "depth": "depth24"},
    Texture: {"image": PICTURE, "filter": ("nearest", "linear"), "wrap": ("repeat", "repeat"),
              "mipmaps": True, "lod": (0.0, 1.0)},
    TextureArray: {"layers": [PICTURE], "format": "rgba8"},
    Texture3D: {"layers": [PICTURE], "format": "rgba8"},
    UniformBuffer: {"values": {"a": 1.0}},
    Variant: {"name": "v", "changes": {"a": 1.0}, "expect": (), "passes": PASSES},
    across: {"start": 0.0, "stop": 1.0},
    any_order: {"output": "a.c"},
    attribute_layout: {"attributes": {"p": (0, 8)}},
    block_layout: {"block": "B", "offsets": {"a": 0}, "size": 16},
    boundaries: {"output": "c", "reference": law, "draw": 0, "given": {}},
    bounded: {"output": "c", "low": 0.0, "high": 1.0, "over": "x", "values": [0.0, 1.0]},
    computed: {"name": "l", "compute": law, "equals": 1.0, "digits": 3},
    coverage: {"pixels": 3},
    exact: {"output": "c", "equals": (0, 0, 0, 1)},
    formula: {"output": "c", "reference": law, "also": {"o": len}, "draw": 0, "given": {}},
    fullscreen: {"fragment": "a.frag", "domain": {"x": across(0.0, 1.0)}, "uniforms": {},
                 "textures": {}, "target": Target(), "state": State(), "name": "main"},
    gl_error: {"error": "invalid_operation"},
    measure: {"label": "l", "statistic": law, "at_most": 1.0},
    compute: {"shader": "a.comp", "groups": (4, 1, 1), "buffers": {"b": [0.0, 1.0]},
              "images": {"i": PICTURE}, "uniforms": {}},
    mesh_pass: {"vertex": "a.vert", "fragment": "a.frag", "mesh": MESH, "tess_control": "a.tesc",
                "tess_evaluation": "a.tese"},
    monotone: {"output": "c", "over": "x", "values": [0.0, 1.0], "direction": "increasing"},
    query: {"counter": "samples_passed", "equals": 3},
    reading: {"label": 1, "at_most": 1.0},
    sweep: {"output": "c", "reference": law, "over": "x", "values": [0.0, 1.0], "at": {}},
    even: {"output": "c", "over": "x", "values": [1.0]},
    odd: {"output": "c", "over": "x", "values": [1.0], "ulp": 2},
    symmetric: {"output": "c", "over": ("a", "b"), "values": [(1.0, 2.0)]},
    up: {"start": 0.0, "stop": 1.0},
    value: {"output": "c", "at": {"x": 1.0}, "equals": 1.0, "digits": 3},
}  # fmt: skip
POSITIONAL = [compile_fails, gl_call, inactive_uniforms, refused]
OTHER = {"cost", "gl_calls", "both_ways", "CompressedTexture", "Rules", "ShaderlabError"}
WRONG = [None, "x", b"x", "", 1.5, -1, True, float("nan"), 3 + 4j, [], [None], ["x"], ("a", 1), {},
         {"x": object()}, {1: 2}, object(), law, Path("x"), np.zeros(0), [[1, 2], [3]], {1, 2},
         Target(), np.array(["x"])]  # fmt: skip


def names(make: Callable[..., Any]) -> str:
    return next(n for n in dir(shaderlab) if getattr(shaderlab, n, None) is make)


def test_every_public_constructor_is_tried() -> None:
    tried = {names(make) for make in [*RIGHT, *POSITIONAL]}
    assert tried | OTHER == {n for n in dir(shaderlab) if not n.startswith("_")}


@pytest.mark.parametrize("make", RIGHT, ids=names)
def test_a_wrong_argument_is_a_sentence(make: Callable[..., Any]) -> None:
    right = RIGHT[make]
    make(**right)
    refusals = 0
    for name in right:
        for wrong in WRONG:
            try:
                make(**{**right, name: wrong})
            except ShaderlabError as error:
                assert len(error.message.split()) > 2
                refusals += 1
    assert refusals > len(right) * len(WRONG) // 4


@pytest.mark.parametrize("make", POSITIONAL, ids=names)
def test_wrong_arguments_in_their_order_are_sentences(make: Callable[..., Any]) -> None:
    for wrong in WRONG:
        for arguments in [(wrong,), ("a.frag", wrong), (wrong, wrong)]:
            try:
                make(*arguments)
            except (ShaderlabError, TypeError) as error:
                # Only Python itself counts arguments.
                counts = "positional" in str(error) or "missing" in str(error)
                assert isinstance(error, ShaderlabError) or counts, arguments


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Case(title="t", passes=PASSES, expect=["x"]), "expect[0] is 'x'; expected Exp"),
        (lambda: Case(title="t", passes=PASSES, expect=formula("c", law)), "; expected list of"),
        (lambda: Target(size=(1.5, 2)), "Target: size[0] is 1.5; expected int"),
        (lambda: Target(size=64), "Target: size is 64; expected (int, int) or None"),
        (lambda: Texture(image=PICTURE, filter="nearest"), "filter is 'nearest'; expected (str, "),
        (lambda: Mesh(attributes={"p": np.zeros((0, 2))}), "Mesh: there are no vertices"),
        (lambda: sweep("c", law, over="x", values=[]), "there are no values of 'x'\n  → values="),
        (lambda: across("a", 1.0), "across: 'a' and 1.0 are not numbers"),
        (lambda: fullscreen("a.frag", uniforms=[1]), "uniforms is [1]; expected mapping of str"),
        (lambda: fullscreen("a.frag", uniforms={"t": TEXTURE}), "uniforms['t'] is Texture(filter"),
        (lambda: fullscreen("a.frag", textures={"t": PICTURE}), "; expected Texture or Texture"),
        (lambda: fullscreen("a.frag", blocks={"B": {"x": 1}}), "blocks['B'] is {'x': 1}; expected"),
        (lambda: mesh_pass("a.vert", "a.frag", {"p": [(0, 0)]}), "mesh is {'p': [(0, 0)]}; exp"),
        (lambda: formula("c", reference="red"), "formula: reference is 'red'; expected function"),
    ],
)
def test_listed_mistakes(make: Callable[[], Any], message: str) -> None:
    with pytest.raises(CaseError) as caught:
        make()
    assert message in str(caught.value)


def test_structures_are_mappings_of_their_members() -> None:
    lamps = [{"on": True, "at": {"x": 1.0}}, {"on": False, "at": {"x": 2.0}}]
    spelt = {
        "lamps[0].on": True,
        "lamps[0].at.x": 1.0,
        "lamps[1].on": False,
        "lamps[1].at.x": 2.0,
        "weights": [0.5, 0.25],
    }
    values = {"lamps": lamps, "weights": [0.5, 0.25]}
    (one,) = fullscreen("a.frag", uniforms=values)
    assert one.draws[0].uniforms == spelt
    assert UniformBuffer(values=values).values == spelt
    assert flatten_structures(spelt) is spelt


def test_a_forgotten_argument_is_named(tmp_path: Path) -> None:
    file = tmp_path / "a.py"
    file.write_text("from shaderlab import Case, value\ncase = value('c', at={}, equals=1)\n")
    with pytest.raises(CaseError, match=r"missing 1 required .*'digits'") as caught:
        load_case(file)
    assert caught.value.line == 2


def test_what_fits_is_taken() -> None:
    """Lists for tuples, NumPy's numbers for Python's."""
    assert Target(size=[np.int64(4), 4]).size == [4, 4]
    assert Pixel(np.int32(1), 2).x == 1
    Ramp(np.zeros(3), dx=[0, np.float32(1), 2])
    Mesh(attributes={"p": [[0, 1], [2, 3]]}, indices=range(2))


def test_exact_takes_no_function() -> None:
    with pytest.raises(CaseError, match="equals is a function") as caught:
        exact("FragColor", lambda uv: uv)
    assert caught.value.remedy == "use formula"
