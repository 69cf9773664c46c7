"""Objects of OpenGL, made and filled by the calls that a program makes, for `gl_call`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from shaderlab.engine.expectations.gl_call import Object, call
from shaderlab.model.calls import Call

Calls = tuple[Call, ...]


def array_of_point(label: str, place: Sequence[float]) -> Calls:
    """A vertex array `label` with a point in attribute 0, and an index buffer with as many bytes as
    the label has letters. Afterwards no buffer is bound as GL_ARRAY_BUFFER."""
    vertices, indices = "GL_ARRAY_BUFFER", "GL_ELEMENT_ARRAY_BUFFER"
    return (
        call("glBindVertexArray", Object("vertex_array", label)),
        call("glBindBuffer", vertices, Object("buffer", f"{label} vertices")),
        call("glBindBuffer", indices, Object("buffer", f"{label} indices")),
        call("glBufferData", vertices, 12, np.array(place, np.float32).tobytes(), "GL_STATIC_DRAW"),
        call("glBufferData", indices, len(label), label.encode(), "GL_STATIC_DRAW"),
        call("glVertexAttribPointer", 0, 3, "GL_FLOAT", "GL_FALSE", 0, 0),
        call("glEnableVertexAttribArray", 0),
        call("glBindBuffer", vertices, 0),
    )


def buffers_bound(sizes: Mapping[str, int]) -> Calls:
    """A buffer for each target, of this size: all are bound before the first one is filled."""
    return (
        *(call("glBindBuffer", target, Object("buffer", target)) for target in sizes),
        *(call("glBufferData", word, n, bytes(n), "GL_STATIC_DRAW") for word, n in sizes.items()),
    )


def depth_alone(word: str, point: str = "GL_DEPTH_ATTACHMENT") -> Calls:
    """A framebuffer of one pixel with nothing but a renderbuffer of this format."""
    buffer = ("GL_RENDERBUFFER", Object("renderbuffer", word))
    return (
        call("glBindFramebuffer", "GL_FRAMEBUFFER", Object("framebuffer", word)),
        call("glBindRenderbuffer", *buffer),
        call("glRenderbufferStorage", "GL_RENDERBUFFER", word, 1, 1),
        call("glFramebufferRenderbuffer", "GL_FRAMEBUFFER", point, *buffer),
        call("glDrawBuffer", "GL_NONE"),
        call("glReadBuffer", "GL_NONE"),
    )


def rows_of_nine_bytes(*alignment: int) -> Calls:
    """A texture of 3 × 2 texels in RGB, filled with the bytes 1, 2, … at this GL_UNPACK_ALIGNMENT,
    the default one if none is given. What is read back has no gaps."""
    image = ("GL_TEXTURE_2D", 0, "GL_RGB8", 3, 2, 0, "GL_RGB", "GL_UNSIGNED_BYTE")
    return (
        call("glBindTexture", "GL_TEXTURE_2D", Object("texture")),
        *(call("glPixelStorei", "GL_UNPACK_ALIGNMENT", n) for n in alignment),
        call("glTexImage2D", *image, bytes(range(1, 25))),
        call("glPixelStorei", "GL_PACK_ALIGNMENT", 1),
    )


def compiled(shader: Object, text: str) -> Calls:
    """A shader is given its text, and compiled."""
    return call("glShaderSource", shader, 1, (text,), None), call("glCompileShader", shader)


def linked(program: Object, texts: Mapping[Object, str]) -> Calls:
    """A program is linked from shaders with these texts."""
    return (
        *(step for shader, text in texts.items() for step in compiled(shader, text)),
        *(call("glAttachShader", program, shader) for shader in texts),
        call("glLinkProgram", program),
    )


def shader_runs_counted(steps: Calls) -> Calls:
    """Calls during which a query counts the runs of the vertex shader."""
    begin = call("glBeginQuery", "GL_VERTEX_SHADER_INVOCATIONS", Object("query"))
    return begin, *steps, call("glEndQuery", "GL_VERTEX_SHADER_INVOCATIONS")
