"""A name in a mapping, or a keyword, that nothing reads is an error that says it: none is dropped,
since what its author meant would then go unchecked."""

from __future__ import annotations

import collections.abc
import inspect
import typing
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import shaderlab
from shaderlab import (
    Case,
    Draw,
    Mesh,
    Pass,
    Target,
    UniformBuffer,
    Variant,
    attribute_layout,
    block_layout,
    boundaries,
    bounded,
    compute,
    cost,
    even,
    exact,
    formula,
    fullscreen,
    gl_calls,
    glsl,
    measure,
    mesh_pass,
    monotone,
    odd,
    reading,
    sweep,
    symmetric,
    value,
)
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderlabError
from shaderlab.glslmath import vec4
from shaderlab.model.options import RunOptions

FLAT = """#version 330 core
uniform Lights { vec4 tint; };
uniform float level, weight;
in vec2 TexCoords;
out vec4 color;
void main() { color = vec4(TexCoords * level * weight, tint.x, 1.0); }
"""
VERTEX = "#version 330 core\nin vec2 p;\nvoid main() { gl_Position = vec4(p, 0.0, 1.0); }\n"
PLAIN = "#version 330 core\nout vec4 color;\nvoid main() { color = vec4(1.0); }\n"
COUNT = """#version 430 core
layout(local_size_x = 4) in;
layout(std430, binding = 0) buffer Data { float numbers[]; };
void main() { numbers[gl_GlobalInvocationID.x] = 1.0; }
"""
FUNCTIONS = """
#ifdef DOUBLE
uniform float gain;
#endif
struct Light { float power; };
float f(float k) { return 2.0 * k; }
float lit(Light one) { return one.power; }
"""

BLOCK = UniformBuffer(values={"tint": (1.0, 0.0, 0.0, 1.0)})
TRIANGLE = np.array([[-1.0, -1.0], [3.0, -1.0], [-1.0, 3.0]])
WHITE = exact("color", (1.0, 1.0, 1.0, 1.0))
FLOATS = glsl.floats(0.0, 1.0)


def right(TexCoords: Any, level: Any, weight: Any, tint: Any) -> Any:
    return vec4(TexCoords * level * weight, tint.x, 1.0)


RIGHT = formula("color", right)


def flat(*expect: Any, **changed: Any) -> Case:
    """A case of one fragment shader that passes, unless something is `changed`."""
    own: dict[str, Any] = {"uniforms": {"level": 1.0, "weight": 1.0}, "blocks": {"Lights": BLOCK}}
    for name, names in changed.items():
        own[name] = {**own.get(name, {}), **names} if isinstance(names, dict) else names
    return Case(title="t", passes=fullscreen("flat.frag", **own), expect=expect or [RIGHT])


def drawn(mesh: Mapping[str, Any], each: Mapping[str, Any] | None = None, **given: Any) -> Case:
    made = Mesh(attributes={"p": TRIANGLE, **mesh}, instance_attributes=each or {})
    passes = mesh_pass("drawn.vert", "plain.frag", made, **given)
    return Case(title="t", passes=passes, expect=[WHITE])


def counted(**given: Any) -> Case:
    own: dict[str, Any] = {"buffers": {"numbers": np.zeros(4)}}
    for name, names in given.items():
        own[name] = {**own.get(name, {}), **names}
    passes = compute("count.comp", groups=(1, 1, 1), **own)
    return Case(title="t", passes=passes, expect=[exact("numbers", 1.0)])


def varied(changes: Mapping[str, Any]) -> Case:
    passes = flat().passes
    return Case(title="t", passes=passes, expect=[RIGHT], variants=[Variant("v", changes)])


def raw(slot: str) -> Case:
    """A case whose only draw has one name too many."""
    made = counted if slot in ("buffers", "images") else flat
    own = made().passes[0].draws[0]
    changed = {**vars(own), slot: {**(getattr(own, slot) or {}), "nosuch": ODD[slot]}}
    return Case(title="t", passes=(Pass(draws=(Draw(**changed),)),), expect=made().expect)


ODD: Mapping[str, Any] = {
    "uniforms": 1.0,
    "textures": shaderlab.Texture(image=np.zeros((2, 2, 4))),
    "blocks": BLOCK,
    "domain": shaderlab.Ramp(0.0, 1.0, 1.0),
    "buffers": np.zeros(4),
    "images": np.zeros((2, 2, 4)),
}
PLACE = shaderlab.Ramp((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
MANY = [(0.0, 0.0), (0.5, 0.5), (1.0, 1.0)]
ONE = {"nosuch": 1.0}

# For each public name that takes a mapping or any keywords, which of them, and calls in which one
# of their names is read by nothing. An empty tuple says that names are words for people.
CASES: Mapping[str, Mapping[str, tuple[Callable[[], Case], ...]]] = {
    "Draw": {slot: (lambda slot=slot: raw(slot),) for slot in ODD},  # type: ignore[misc]
    "fullscreen": {
        slot: (lambda slot=slot: flat(**{slot: {"nosuch": ODD[slot]}}),)  # type: ignore[misc]
        for slot in ("uniforms", "textures", "blocks")
    }
    | {"domain": (lambda: flat(domain={"TexCoords": PLACE, "nosuch": ODD["domain"]}),)},
    "mesh_pass": {
        slot: (lambda slot=slot: drawn({}, **{slot: {"nosuch": ODD[slot]}}),)  # type: ignore[misc]
        for slot in ("uniforms", "textures", "blocks")
    },
    "compute": {
        slot: (lambda slot=slot: counted(**{slot: {"nosuch": ODD[slot]}}),)  # type: ignore[misc]
        for slot in ("buffers", "images", "uniforms", "textures", "blocks")
    },
    "Mesh": {
        "attributes": (lambda: drawn({"nosuch": TRIANGLE}),),
        "instance_attributes": (lambda: drawn({}, {"nosuch": TRIANGLE}, instances=3),),
    },
    "Target": {"colors": (lambda: flat(target=Target(colors={"nosuch": "rgba8"})),)},
    "UniformBuffer": {
        "values": (lambda: flat(blocks={"Lights": UniformBuffer(values={**BLOCK.values, **ONE})}),)
    },
    "Variant": {"changes": (lambda: varied({"level": 0.5, "nosuch": 1.0}),)},
    "attribute_layout": {"attributes": (lambda: flat(attribute_layout({"nosuch": (0, 8)})),)},
    "block_layout": {"offsets": (lambda: flat(block_layout("Lights", {"tint": 0, "nosuch": 16})),)},
    "formula": {
        "given": (lambda: flat(formula("color", right, given=ONE)),),
        "also": (),
    },
    "boundaries": {"given": (lambda: flat(boundaries("color", right, given=ONE)),)},
    "sweep": {
        "given": (lambda: flat(sweep("color", right, over="level", values=[0.0, 1.0], given=ONE)),),
        "at": (lambda: flat(sweep("color", right, over="level", values=[0.0, 1.0], at=ONE)),),
    },
    "value": {
        "given": (
            lambda: flat(RIGHT, value("color", equals=(0.0, 0.0, 1.0, 1.0), digits=3,
                                      at={"TexCoords": (0, 0)}, given=ONE)),
            lambda: flat(value("color", equals=(0.0, 0.0, 1.0, 1.0), digits=3,
                               at={"TexCoords": (0, 0)}, given=ONE)),
        ),
        "at": (lambda: flat(value("color", equals=(1.0, 1.0, 1.0, 1.0), digits=3, at=ONE)),),
    },
    "bounded": {
        "at": (lambda: flat(bounded("color", 0.0, 1.0, over="TexCoords", values=MANY, at=ONE)),)
    },
    "monotone": {
        "at": (lambda: flat(monotone("color", over="level", values=[0.0, 1.0], at=ONE)),)
    },
    "even": {"at": (lambda: flat(even("color", over="level", values=[1.0, 2.0], at=ONE)),)},
    "odd": {"at": (lambda: flat(odd("color", over="level", values=[1.0, 2.0], at=ONE)),)},
    "symmetric": {
        "at": (
            lambda: flat(symmetric("color", over=("level", "weight"), values=[(0.0, 1.0)], at=ONE)),
        )
    },
    "measure": {
        "reads": (
            lambda: flat(measure("m", lambda color: color.max(), at_most=9.0,
                                 reads={"nosuch": "color"})),
        ),
        "given": (lambda: flat(measure("m", lambda color: color.max(), at_most=9.0, given=ONE)),),
    },
    "reading": {
        "reads": (
            lambda: flat(measure("m", lambda color: color.max(), at_most=9.0,
                                 readings=[reading("r", reads={"nosuch": "color"})])),
        ),
        "given": (
            lambda: flat(measure("m", lambda color: color.max(), at_most=9.0,
                                 readings=[reading("r", given=ONE)])),
        ),
    },
    "cost": {
        "series": (lambda: flat(cost({"a": {1: "nosuch"}})),),
        "draw_calls": (lambda: flat(cost({"a": {1: "main"}}, draw_calls={"nosuch": int})),),
        "vertices": (lambda: flat(cost({"a": {1: "main"}}, vertices={"nosuch": int})),),
    },
    "gl_calls": {
        "arguments": tuple(
            lambda made=made: flat(made)  # type: ignore[misc]
            for made in (
                gl_calls("glDrawArrays", nosuch=1),
                gl_calls("glTexImage3D", times=0, nosuch=1),
                gl_calls("glnosuch", times=0),
                gl_calls("glDrawArrays", times=0, after="glnosuch"),
            )
        )
    },
    # Parts of vendors' names, of which a driver has one.
    "compile_fails": {"departs": ()},
    "gl_call": {"departs": ()},
}  # fmt: skip


def load(**given: Any) -> glsl.Library:
    return glsl.load(FUNCTIONS, **given)


def tried(one: glsl.Function, /, **domains: Any) -> None:
    glsl.given(one, **domains)(lambda result: None)()


def example_with(**values: Any) -> None:
    glsl.given(load().f, k=FLOATS)(glsl.example(**values)(lambda k, result: None))()


POWER = {"power": 1.0, "nosuch": 1.0}
FUNCTION_CALLS: Mapping[str, tuple[Callable[[], object], ...]] = {
    "load defines": (
        lambda: load(defines={"nosuch": ""}),
        lambda: load(defines={"nosuch(x)": "x"}),
    ),
    "load given": (lambda: load(nosuch=1.0),),
    "given domains": (
        lambda: tried(load().f, k=FLOATS, nosuch=FLOATS),
        lambda: tried(load().f, k=FLOATS, nosuch=1.0),
        lambda: tried(load().lit, one={"power": FLOATS, "nosuch": 1.0}),
        lambda: tried(load().lit, one={"power": FLOATS, "nosuch": FLOATS}),
    ),
    "example values": (lambda: example_with(k=1.0, nosuch=1.0),),
    "Function.__call__ named": (
        lambda: load().f(1.0, nosuch=1.0),
        lambda: load().lit(POWER),
    ),
    "Function.check named": (
        lambda: load().f.check(lambda k: 2.0 * k, [1.0, 2.0], nosuch=1.0),
        lambda: load().f.check(lambda k: 2.0 * k, k=(0.0, 1.0), every=1 << 24, nosuch=1.0),
        lambda: load().lit.check(lambda power: power, POWER),
    ),
    "Function.prove ranges": (lambda: load().f.prove(lambda y: y >= 0.0, k=(0, 1), nosuch=(0, 1)),),
}
CALLS = [
    pytest.param(make, id=f"{name} {slot} {number}")
    for name, slots in CASES.items()
    for slot, made in slots.items()
    for number, make in enumerate(made)
]


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(pictures=False, size=8)) as lab:
        yield lab


def _said(lab: SceneRunner, folder: Path, make: Callable[[], Case]) -> str:
    """What is wrong with a case; "" if it passes."""
    texts = {"flat.frag": FLAT, "drawn.vert": VERTEX, "plain.frag": PLAIN, "count.comp": COUNT}
    for name, text in texts.items():
        (folder / name).write_text(text)
    try:
        case = make()
        object.__setattr__(case, "file", str(folder / "a.py"))
        scenes = list(case.scenes())
    except ShaderlabError as error:
        return str(error)
    records = [lab.run(scene) for scene in scenes]
    messages = [
        message for r in records for message in (r.message, *(o.message for o in r.expectations))
    ]
    return "\n".join(messages).strip() if any(r.status != "pass" for r in records) else ""


@pytest.mark.parametrize("make", [flat, lambda: drawn({}), counted])
def test_without_such_a_name_these_cases_pass(
    lab: SceneRunner, tmp_path: Path, make: Callable[[], Case]
) -> None:
    assert _said(lab, tmp_path, make) == ""


@pytest.mark.parametrize("make", CALLS)
def test_a_name_that_nothing_reads_is_an_error_of_a_case(
    lab: SceneRunner, tmp_path: Path, make: Callable[[], Case]
) -> None:
    said = _said(lab, tmp_path, make)
    assert "nosuch" in said and "defect" not in said


@pytest.mark.parametrize(
    "call", [c for calls in FUNCTION_CALLS.values() for c in calls], ids=lambda _: ""
)
def test_a_name_that_nothing_reads_is_an_error_of_a_functions_test(
    call: Callable[[], object],
) -> None:
    with pytest.raises(ShaderlabError, match="nosuch"):
        call()


def _takes_mapping(hint: Any) -> bool:
    if (typing.get_origin(hint) or hint) in (collections.abc.Mapping, dict):
        return True
    return any(_takes_mapping(inner) for inner in typing.get_args(hint))


def _slots(function: Any) -> set[str]:
    """The parameters of a function or class that take names: mappings, and any keywords."""
    hints = typing.get_type_hints(inspect.unwrap(function))
    parameters = inspect.signature(function).parameters.values()
    return {
        p.name for p in parameters if p.kind is p.VAR_KEYWORD or _takes_mapping(hints.get(p.name))
    }


def test_all_that_takes_names_is_tried_here() -> None:
    """Whoever adds a mapping to what cases and tests are written with, tries it here."""
    public = {name: getattr(shaderlab, name) for name in shaderlab.__all__}
    slots = {n: _slots(f) for n, f in public.items() if callable(f) and n != "Case"}
    assert {n: found for n, found in slots.items() if found} == {n: {*s} for n, s in CASES.items()}
    own = {"load": glsl.load, "given": glsl.given, "example": glsl.example}
    own |= {f"Function.{n}": getattr(glsl.Function, n) for n in ("__call__", "check", "prove")}
    assert {f"{n} {slot}" for n, f in own.items() for slot in _slots(f)} == {*FUNCTION_CALLS}
