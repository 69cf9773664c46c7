"""Calls of OpenGL as text: what each argument is mistaken for, and which state a call finds."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from shaderlab.drivers.opengl.tracing import StateTracker
from shaderlab.model.frame import TracedCall
from shaderlab.mutation.call_mutants import vary_arguments

Called = tuple[str, Mapping[str, str]]


def call(function: str, **arguments: str) -> Called:
    return function, arguments


def states(*calls: Called) -> list[str]:
    """The digests of the calls that do more than set state."""
    tracker, found = StateTracker(), []
    for function, arguments in calls:
        found.append(tracker.state_for(function))
        tracker.changes(function, arguments)
    return [state for state in found if state]


@pytest.mark.parametrize(
    ("called", "others"),
    [
        (
            call("glBufferData", size="168", usage="GL_STATIC_DRAW"),
            {("usage", "GL_STREAM_DRAW"), ("usage", "GL_STATIC_READ"), ("size", 164)},
        ),
        (call("glVertexAttribPointer", stride="24", pointer="byte 12"),
         {("stride", 28), ("pointer", 8)}),
        (call("glVertexAttribPointer", stride="0", pointer="NULL"), {("stride", 4)}),
        (call("glSamplerParameteri", param="GL_REPEAT"),
         {("param", "GL_CLAMP_TO_EDGE"), ("param", "GL_MIRRORED_REPEAT")}),
        (call("glUniform1fv", location="0", count="1", value="[1]"), set()),
    ],
)  # fmt: skip
def test_what_an_argument_is_mistaken_for(called: Called, others: set[tuple[str, object]]) -> None:
    function, arguments = called
    traced = TracedCall(pass_name="main", draw=0, function=function, arguments=arguments)
    assert set(vary_arguments(traced)) == others


DRAW = call("glDrawArrays", mode="GL_POINTS", first="0", count="1")
LEFT = call("glBindTexture", target="GL_TEXTURE_2D", texture="texture 1")
RIGHT = call("glBindTexture", target="GL_TEXTURE_2D", texture="texture 2")
UNIT = call("glActiveTexture", texture="GL_TEXTURE1")
BLEND = call("glBlendColor", red="1", green="0", blue="0", alpha="0")


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ((LEFT, RIGHT, DRAW), (RIGHT, DRAW), True),
        ((LEFT, DRAW), (RIGHT, DRAW), False),
        ((LEFT, UNIT, LEFT, DRAW), (LEFT, UNIT, DRAW), False),
        ((BLEND, DRAW), (DRAW,), True),  # blending is off
        ((call("glEnable", cap="GL_BLEND"), BLEND, DRAW),
         (call("glEnable", cap="GL_BLEND"), DRAW), False),
    ],
)  # fmt: skip
def test_the_state_that_a_draw_finds(
    one: tuple[Called, ...], other: tuple[Called, ...], same: bool
) -> None:
    assert (states(*one) == states(*other)) is same


def test_a_buffer_is_bound_for_each_vertex_array() -> None:
    """That of indices is the vertex array's."""
    bind = call("glBindBuffer", target="GL_ELEMENT_ARRAY_BUFFER", buffer="buffer 1")
    tracker = StateTracker()
    assert tracker.changes(*bind) and not tracker.changes(*bind)
    tracker.changes(*call("glBindVertexArray", array="vertex array 2"))
    assert tracker.changes(*bind)


def test_after_an_object_is_deleted_binding_its_number_does_something() -> None:
    """OpenGL unbinds what is deleted, and may give its number to the next object."""
    tracker = StateTracker()
    assert tracker.changes(*LEFT) and not tracker.changes(*LEFT)
    assert tracker.changes(*call("glDeleteTextures", n="1", textures="texture 1"))
    assert tracker.changes(*LEFT)
