"""What a shipped case draws is held against something: no output goes unread.

Outputs are found in the shaders' texts, as compiling every program takes a minute.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import pytest

from shaderlab.compiler.sources import Shaders
from shaderlab.drivers.opengl.calls import constant
from shaderlab.engine.catalogue import data_folder
from shaderlab.engine.expectations.base import unread_outputs
from shaderlab.engine.expectations.gl_call import GlCall
from shaderlab.model.case import Case, Scene
from tests.catalogue import shipped

OUTPUT = re.compile(r"^(?:layout *\([^)]*\) *)?(?:flat +)?out +\w+ +(\w+) *;", re.MULTILINE)
WRITTEN = re.compile(
    r"^layout \([^)]*\) (?:writeonly )?(?:buffer \w+ \{|uniform \w*image2D) (.*);", re.M
)


@cache
def outputs_of(shader: str) -> tuple[str, ...]:
    """The outputs that a fragment shader declares, in itself or in what it includes; of a compute
    shader the images and the one member of each buffer that it may write."""
    text = Shaders([data_folder("shaders")]).load(shader).text
    members = (re.findall(r"\w+", declared)[-1] for declared in WRITTEN.findall(text))
    return (*OUTPUT.findall(text), *members)


def programs_of(scene: Scene) -> dict[str, tuple[Any, ...]]:
    """What `unread_outputs` asks of a scene's programs: each draw's outputs."""
    return {
        one.name: tuple(
            SimpleNamespace(outputs=outputs_of(draw.compute or draw.fragment)) for draw in one.draws
        )
        for one in scene.passes
    }


def unread(case: Case) -> Iterator[str]:
    for scene in case.scenes():
        for name in unread_outputs(scene, programs_of(scene)):
            yield f"{name} ({scene.variant})"


@pytest.mark.parametrize("case", [pytest.param(case, id=case.id) for case in shipped().values()])
def test_no_output_is_unread(case: Case) -> None:
    assert list(unread(case)) == []


BLOCK = re.compile(r"^out (\w+) *\{([^}]*)\}", re.MULTILINE)


def entering(vertex: str) -> set[str]:
    """What a vertex shader gives a geometry shader after it, as expectations name it."""
    text = Shaders([data_folder("shaders")]).load(vertex).text
    members = {
        f"{block}.{name}"
        for block, inside in BLOCK.findall(text)
        for name in re.findall(r"(\w+);", inside)
    }
    return {"gl_in.gl_Position", *OUTPUT.findall(text), *members}


def unread_before_geometry(scene: Scene) -> Iterator[str]:
    """Vertex shaders before a geometry shader of which something is read in no pass."""
    read = {(read.pass_name, read.output) for e in scene.expect for read in e.find_reads(scene)}
    drawn = {(d.vertex, one.name) for one in scene.passes for d in one.draws if d.geometry}
    for vertex in sorted({vertex for vertex, _ in drawn if vertex}):
        missing = entering(vertex) - {o for p, o in read if (vertex, p) in drawn}
        yield from (f"{vertex}: {name}" for name in sorted(missing))


def test_what_enters_a_geometry_stage_is_judged() -> None:
    scenes = {name: next(case.scenes()) for name, case in shipped().items()}
    assert [name for scene in scenes.values() for name in unread_before_geometry(scene)] == []
    blind = replace(scenes["geometry-houses"], expect=())
    names = [name.split(": ")[1] for name in unread_before_geometry(blind)]
    assert names == ["gl_in.gl_Position", "wall"]


def test_an_output_that_nothing_reads_is_found() -> None:
    case = shipped()["triangle"]
    scene = next(case.scenes())
    blind = replace(scene, expect=())
    assert unread_outputs(blind, programs_of(blind)) == ("picture.FragColor", "main.FragColor")


@pytest.mark.parametrize("case", shipped().values(), ids=list(shipped()))
def test_a_question_to_opengl_has_an_answer_that_is_not_0(case: Case) -> None:
    """A driver that answers 0, GL_FALSE or GL_NONE to all of them passes where each is to be."""
    wanted: dict[str, list[float]] = {}
    for expectation in next(case.scenes()).expect:
        if isinstance(expectation, GlCall) and expectation.returns is not None:
            numbers = [constant(w) if isinstance(w, str) else w for w in expectation.returns]
            wanted.setdefault(expectation.call.function, []).extend(numbers)
    assert [function for function, numbers in wanted.items() if not any(numbers)] == []
