"""Tables of what OpenGL answers to calls, and calls that several lessons make before theirs."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import chain
from typing import Any

from shaderlab import gl_call, gl_calls
from shaderlab.engine.expectations.gl_call import Object, Program, call
from shaderlab.model.calls import Call

_COLOR = ("GL_FRAMEBUFFER", "GL_COLOR_ATTACHMENT0", "GL_RENDERBUFFER")

ONE_PIXEL = (
    call("glBindFramebuffer", "GL_FRAMEBUFFER", Object("framebuffer", "pixel")),
    call("glBindRenderbuffer", "GL_RENDERBUFFER", Object("renderbuffer", "pixel")),
    call("glRenderbufferStorage", "GL_RENDERBUFFER", "GL_RGBA8", 1, 1),
    call("glFramebufferRenderbuffer", *_COLOR, Object("renderbuffer", "pixel")),
    call("glViewport", 0, 0, 1, 1),
)
"""A framebuffer of one pixel, to be drawn into and read."""


PIXEL = call("glReadPixels", 0, 0, 1, 1, "GL_RGBA", "GL_UNSIGNED_BYTE")
"""What is in that pixel, as four bytes."""


def in_use(program: Program | None = None) -> tuple[Call, ...]:
    """Calls before a draw into `ONE_PIXEL`: a program, the last pass's by default, and a vertex
    array of its own.

    >>> [step.function for step in in_use()][-2:]
    ['glUseProgram', 'glBindVertexArray']
    """
    vertices = call("glBindVertexArray", Object("vertex_array"))
    return *ONE_PIXEL, call("glUseProgram", program or Program()), vertices


def pixel(color: tuple[int, int, int], *steps: tuple[Call, ...]) -> tuple[Any, ...]:
    """A row for `answers`: the opaque colour, in bytes, of a point drawn after these steps."""
    point = (call("glDrawArrays", "GL_POINTS", 0, 1),)
    return PIXEL, (*color, 255), in_use(), *steps, point


Departures = Mapping[str, Mapping[str, str]]
"""A row's name → the drivers that are known to answer otherwise, as `gl_call` takes them."""


def answers(rows: Mapping[str, tuple[Any, ...]], departs: Departures | None = None) -> list[Any]:
    """A `gl_call` for each row: its name → (the call, what it returns or writes, and if any come
    before it, groups of calls in order).

    >>> made = (call("glBindBuffer", "GL_ARRAY_BUFFER", Object("buffer")),)
    >>> rows = {"one": (call("glIsBuffer", Object("buffer")), "GL_TRUE", made)}
    >>> [(check.name, check.returns) for check in answers(rows)]
    [('one', ('GL_TRUE',))]
    """
    return [
        gl_call(
            asked.function,
            *asked.arguments,
            returns=returns,
            before=(*chain(*before),),
            name=name,
            departs=(departs or {}).get(name),
        )
        for name, (asked, returns, *before) in rows.items()
    ]


def errors(rows: Mapping[str, tuple[Any, ...]], departs: Departures | None = None) -> list[Any]:
    """A `gl_call` for each row: its name → (the call, the error that it raises, and if any come
    before it, groups of calls in order).

    >>> unmap = call("glUnmapBuffer", "GL_ARRAY_BUFFER")
    >>> [check.raises for check in errors({"none": (unmap, "invalid_operation")})]
    ['invalid_operation']
    """
    return [
        gl_call(
            asked.function,
            *asked.arguments,
            raises=raises,
            before=(*chain(*before),),
            name=name,
            departs=(departs or {}).get(name),
        )
        for name, (asked, raises, *before) in rows.items()
    ]


def sent(pass_name: str | None, rows: Mapping[str, tuple[Any, ...]]) -> list[Any]:
    """A `gl_calls` for each row: its name → (the function, how often the driver gets it, and if
    only some calls count, the arguments that they have).

    Args:
        pass_name: the pass that is drawn; the last one if it is None.

    >>> rows = {"in one piece": ("glBufferData", 1, {"size": 168})}
    >>> [check.name for check in sent("main", rows)]
    ['in one piece']
    """
    return [
        gl_calls(function, times=times, pass_name=pass_name, name=name, **dict(*arguments))
        for name, (function, times, *arguments) in rows.items()
    ]


def limits(rows: Mapping[str, tuple[str, int]]) -> list[Any]:
    """A `gl_call` for each limit of the driver's: what it is → (its word, the least that OpenGL
    promises).

    >>> [check.at_least for check in limits({"samples of a pixel": ("GL_MAX_SAMPLES", 4)})]
    [True]
    """
    return [
        gl_call("glGetIntegerv", word, at_least=least, name=name)
        for name, (word, least) in rows.items()
    ]
