"""Mistakes planted on one of two drivers: the matrix finds each, and blames the path."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Blend,
    Case,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    Ramp,
    State,
    Target,
    Texture,
    UniformBuffer,
    formula,
)
from shaderlab.cli.compare_drivers import find_disagreements
from shaderlab.compiler.spirv import parse
from shaderlab.drivers.opengl import drawing, linking, target, textures
from shaderlab.drivers.opengl.device import GL
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import vec4
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Disagreement, Record

ADDED = Blend(source="one", destination="one")
PATHS = ("llvmpipe", "llvmpipe-spirv")
VERTEX = """#version 330 core
in vec3 place; in vec2 at; in float number; in float shift;
uniform mat4 camera;
layout (std140) uniform Scene { vec4 tint; vec4 gain; };
out vec2 uv; flat out float id; out vec4 tone;
void main() {
    uv = at; id = number + shift; tone = tint * gain.x;
    gl_Position = camera * vec4(place + vec3(shift, 0.0, 0.0), 1.0);
}
"""
FRAGMENT = """#version 330 core
in vec2 uv; flat in float id; in vec4 tone;
uniform sampler2D image; uniform float bright; uniform float dim;
out vec4 color; out vec4 marks;
void main() {
    color = texture(image, uv) * tone * bright + vec4(0.125);
    marks = vec4(uv, id, dim);
}
"""
FLAT = """#version 330 core
in float level; out vec4 color;
void main() { color = vec4(level, 0.5 * level, 0.25, 0.5); }
"""
SECOND = """#version 330 core
in vec2 st; uniform sampler2D before; out vec4 color;
void main() { color = texture(before, st * 3.0 - 1.0) * 0.5; }
"""


def shaded(level: Any) -> Any:
    return vec4(level, 0.5 * level, 0.25, 0.5)


def added(level: Any) -> Any:
    return shaded(level) + vec4(0.5, 0.25, 0.25, 0.5)


def scene(folder: Path) -> Any:
    """Two instances of a folded sheet, blended and depth-tested screens, and a pass that reads."""
    for name, text in {"sheet.vert": VERTEX, "sheet.frag": FRAGMENT, "flat.frag": FLAT,
                       "second.frag": SECOND}.items():  # fmt: skip
        (folder / name).write_text(text)
    texels = np.random.default_rng(5).random((8, 8, 4)).astype(np.float32)
    sheet = Mesh(
        attributes={
            "place": np.array([[-0.9, -0.8, 0.1], [0.3, -0.7, 0.5], [0.4, 0.7, -0.2],
                               [-0.7, 0.9, 0.3]], np.float32),
            "at": np.array([[0, 0], [1.5, 0.2], [1.4, 1.7], [-0.3, 1.2]], np.float32),
            "number": np.array([[1], [2], [3], [4]], np.float32),
        },
        instance_attributes={"shift": np.array([[0.0], [0.55]], np.float32)},
        indices=np.array([0, 1, 2, 0, 2, 3]),
    )  # fmt: skip
    camera = np.array([[0.9, 0.1, 0, 0], [0, 1.1, 0.2, 0], [0.1, 0, 0.8, 0], [0.2, 0.1, 0.3, 1.2]])
    block = UniformBuffer(values={"tint": (0.9, 0.7, 0.5, 1.0), "gain": (0.75, 0.1, 0.2, 0.3)})
    image = Texture(image=texels, filter=("linear", "linear"), wrap=("repeat", "clamp_to_edge"))
    draw = Draw(
        vertex="sheet.vert", fragment="sheet.frag", mesh=sheet, instances=2,
        uniforms={"camera": camera, "bright": 0.8, "dim": 0.3}, textures={"image": image},
        blocks={"Scene": block}, state=State(cull="back", scissor=(2, 2, 26, 27)),
    )  # fmt: skip

    cleared = Target(size=(32, 32), clear=(0.2, 0.3, 0.4, 1.0))

    def screen(level: float, state: State) -> Draw:
        return Draw(fragment="flat.frag", domain={"level": Ramp(level)}, state=state)

    return Case(
        id="paths", title="paths", file=str(folder / "paths.py"),
        passes=(
            Pass(name="sheet", target=cleared, draws=(draw,)),
            Pass(name="blended", draws=(
                screen(0.5, State()), screen(0.25, State(blend=ADDED)),
            )),
            Pass(name="near", target=Target(depth="depth24", clear_depth=0.75), draws=(
                screen(1.0, State(depth=Depth(func="less"))),
            )),
            Pass(name="second", draws=(Draw(
                fragment="second.frag", domain={"st": Ramp((0, 0), dx=(1, 0), dy=(0, 1))},
                textures={"before": Output("sheet.color", filter=("nearest", "nearest"))},
            ),)),
        ),
        expect=(
            formula("blended.color", added, draw=1),
            formula("near.color", shaded),
        ),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("paths")


@pytest.fixture(scope="module")
def made(folder: Path) -> Any:
    return next(iter(scene(folder).scenes()))


Plant = Callable[[pytest.MonkeyPatch], None]


def call(name: str, change: Callable[..., tuple[Any, ...]]) -> Plant:
    """A call of OpenGL is made with other arguments."""

    def plant(patch: pytest.MonkeyPatch) -> None:
        before = getattr(GL, name)
        patch.setattr(GL, name, lambda *given: before(*change(*given)))

    return plant


def constant(name: str, word: int, other: int) -> Plant:
    """A constant among a call's arguments is another one."""
    return call(name, lambda *given: tuple(other if g == word else g for g in given))


def uniform(change: Callable[[str, Any], Any]) -> Plant:
    """Uniforms are uploaded otherwise."""

    def plant(patch: pytest.MonkeyPatch) -> None:
        before = drawing.set_uniforms

        def changed(program: Any, values: Mapping[str, Any]) -> list[str]:
            return before(program, {name: change(name, v) for name, v in values.items()})

        patch.setattr(drawing, "set_uniforms", changed)

    return plant


def text(pattern: str, new: str) -> Plant:
    """A path makes its program of another text."""

    def plant(patch: pytest.MonkeyPatch) -> None:
        before = linking.link_modules

        def changed(device: Any, texts: Mapping[str, str], feedback: Any) -> Any:
            return before(device, {s: re.sub(pattern, new, t) for s, t in texts.items()}, feedback)

        patch.setattr(linking, "link_modules", changed)

    return plant


def instruction(op: int, other: int) -> Plant:
    """A translation writes another instruction."""

    def plant(patch: pytest.MonkeyPatch) -> None:
        before = linking.modules_of

        def changed(stages: Any) -> Any:
            modules, interface = before(stages)
            if "fragment" not in modules:
                return modules, interface
            words = list(parse(modules["fragment"]).words)
            for each in parse(modules["fragment"]).body:
                if each.op == op:
                    words[each.at] = words[each.at] & 0xFFFF0000 | other
            data = struct.pack(f"{len(words)}I", *words)
            return {**modules, "fragment": data}, interface

        patch.setattr(linking, "modules_of", changed)

    return plant


def method(owner: Any, name: str, make: Callable[[Any], Any]) -> Plant:
    """A function of the backend does something else."""
    return lambda patch: patch.setattr(owner, name, make(getattr(owner, name)))


def _swapped(before: Any) -> Any:
    def changed(program: Any, names: Any) -> dict[str, int]:
        found = before(program, names)
        if {"color", "marks"} <= found.keys():
            found["color"], found["marks"] = found["marks"], found["color"]
        return dict(found)

    return changed


def _turned(before: Any) -> Any:
    return lambda place, level, format, image, **how: before(
        place, level, format, image[::-1].copy(), **how
    )


def _upside_down(before: Any) -> Any:
    return lambda self, name: replace(image := before(self, name), values=image.values[::-1].copy())


FRONT = {0x0900: 0x0901, 0x0901: 0x0900}  # GL_CW, GL_CCW
FAULTS: Mapping[str, tuple[Plant, str, bool]] = {
    # What is planted, the output that differs, and whether an expectation or the shader's own band
    # is left there: what happens before the fragment stage is seen, and blamed on nobody.
    "the winding flipped": (
        call("glFrontFace", lambda face: (FRONT[face],)), "sheet.color", False),
    "the other face culled": (constant("glCullFace", 0x0405, 0x0404), "sheet.color", False),
    "culling left on for nothing": (
        call("glCullFace", lambda face: (0x0408,)), "sheet.color", False),
    "a viewport three pixels off": (
        call("glViewport", lambda x, y, *size: (x + 3, y, *size)), "sheet.color", False),
    "a scissor rectangle off": (
        call("glScissor", lambda x, y, *size: (x + 6, y, *size)), "sheet.color", False),
    "rows read upside down": (
        method(target.RenderTarget, "read", _upside_down), "sheet.color", False),
    "another range of depth": (
        call("glDepthRange", lambda near, far: (0.5, 1.0)), "sheet.color", False),
    "a matrix transposed": (
        uniform(lambda n, v: v.T.copy() if n == "camera" else v), "sheet.color", False),
    "a uniform that was not set": (
        uniform(lambda n, v: v * 0 if n == "dim" else v), "sheet.marks", True),
    "nearest for linear": (
        constant("glSamplerParameteri", 0x2601, 0x2600), "sheet.color", True),
    "another wrap": (
        constant("glSamplerParameteri", 0x2901, 0x8370), "sheet.color", True),
    "a wrong offset of an attribute": (
        call("glVertexAttribPointer", lambda at, n, *rest: (at, n, *rest[:-1], rest[-1] if n == 3
             else type(rest[-1])((rest[-1].value or 0) + 4))), "sheet.marks", False),
    "a wrong stride": (
        call("glVertexAttribPointer", lambda at, n, kind, norm, stride, where: (
            at, n, kind, norm, stride + (4 if n == 2 else 0), where)),
        "sheet.marks", False),
    "an attribute that goes on once a vertex": (
        call("glVertexAttribDivisor", lambda at, divisor: (at, 0)), "sheet.color", False),
    "another provoking vertex": (
        call("glFrontFace", lambda face: (GL.glProvokingVertex(0x8E4D), (face,))[1]),
        "sheet.marks", False),
    "no perspective": (
        text(r"(in|out) vec2 uv", r"noperspective \1 vec2 uv"), "sheet.marks", False),
    "the outputs exchanged": (
        method(drawing, "output_locations", _swapped), "sheet.marks", True),
    "cleared to another colour": (
        call("glClearBufferfv", lambda what, n, at: (what, n, at + np.float32(0.25) * (at != 0))),
        "sheet.color", False),
    "an instance too few": (
        call("glDrawElementsInstanced", lambda *given: (*given[:-1], given[-1] - 1)),
        "sheet.color", False),
    "an index too late": (
        call("glDrawElementsInstanced", lambda mode, n, *rest: (mode, n - 3, *rest)),
        "sheet.color", False),
    "another factor of blending": (
        call("glBlendFuncSeparate", lambda *given: (given[0], 0, given[2], 0)),
        "blended.color", True),
    "another depth test": (constant("glDepthFunc", 0x0201, 0x0204), "near.color", True),
    "a texture upside down": (
        method(textures, "_set_image", _turned), "sheet.color", True),
    "a subtraction translated for an addition": (
        instruction(129, 131), "sheet.color", True),
    "an edge that repeats": (
        constant("glSamplerParameteri", 0x812F, 0x2901), "sheet.color", True),
}  # fmt: skip


def drawn(driver: str, made: Any, folder: Path) -> Any:
    """The record of a scene on a driver."""
    options = RunOptions(driver=driver, size=32, pictures=False, frames=folder / driver)
    with SceneRunner(options) as lab:
        return replace(lab.run(made), driver_name=driver)


@pytest.fixture(scope="module")
def clean(made: Any, folder: Path) -> Record:
    """The record of the path without a mistake."""
    record: Record = drawn(PATHS[0], made, folder)
    return record


def matrix(made: Any, clean: Record, folder: Path, plant: Plant | None) -> dict[str, Disagreement]:
    """Each output on both paths, something planted in the second."""
    records = [clean]
    with pytest.MonkeyPatch.context() as patch:
        if plant is not None:
            patch.setattr(SceneRunner, "backend", _planted(plant, patch))
        records.append(drawn(PATHS[1], made, folder))
        assert [r.message for r in records] == ["", ""]
    return {d.output: d for d in find_disagreements(records, folder)}


def _planted(plant: Plant, patch: pytest.MonkeyPatch) -> Any:
    """A lab's device, with something planted once it is open."""
    before = SceneRunner.backend.fget
    waiting = [plant]

    def backend(self: SceneRunner) -> Any:
        found = before(self)  # type: ignore[misc]
        while waiting:
            waiting.pop()(patch)
        return found

    return property(backend)


def test_without_a_mistake_nothing_is_outside(made: Any, clean: Record, folder: Path) -> None:
    found = matrix(made, clean, folder, None)
    assert len(found) == 5
    assert {d.verdict for d in found.values()} <= {"equal", "within"}, [
        f"{d.output} {d.verdict}" for d in found.values()
    ]


@pytest.mark.parametrize("fault", FAULTS)
def test_a_mistake_is_found_and_its_path_blamed(
    made: Any, clean: Record, folder: Path, fault: str
) -> None:
    plant, output, blamed = FAULTS[fault]
    found = matrix(made, clean, folder, plant)[output]
    assert found.differing, found
    assert found.outside == ((PATHS[1],) if blamed else ()), found
