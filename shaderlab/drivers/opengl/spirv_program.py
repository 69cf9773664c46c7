"""Programs that the driver gets as SPIR-V modules instead of text (GL_ARB_gl_spirv).

A linked module has no names: locations and bindings are those that the modules say, by the names
of the lab's own reflection.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from shaderlab.compiler.compile_cache import cached_compiler
from shaderlab.compiler.interface import Interface, Variable
from shaderlab.compiler.module import parse
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.compiler.transform_feedback import with_feedback
from shaderlab.errors import ShaderError, UnsupportedError

from ..programs.formats import components_of
from .device import Device
from .pyopengl import GL, GLError, gl_spirv, named

_STAGES = ("vertex", "tess_control", "tess_evaluation", "geometry", "fragment", "compute")
_SPIRV = 0x9551  # GL_SHADER_BINARY_FORMAT_SPIR_V
_NUMPY = {"ui": np.uint32, "i": np.int32, "d": np.float64, "f": np.float32}
# Execution modes of geometry stages, and what their strips are made of.
_EMITTED = {27: "points", 28: "lines", 29: "triangles"}


def modules_of(stages: Sequence[Source]) -> tuple[Mapping[str, bytes], Interface]:
    """A program's modules for OpenGL by stage, and its interface.

    Raises:
        UnsupportedError: it can't become SPIR-V; it may still be plain GLSL.
    """
    compiled = cached_compiler()(stages, ("glsl", "opengl"))
    try:
        compiled.require()
    except ShaderError as error:
        message = f"it has no SPIR-V module for OpenGL: {error.message}"
        raise UnsupportedError(message, file=error.file, line=error.line) from error
    assert compiled.interface is not None
    return compiled.spirv["opengl"], compiled.interface


def specialise(shader: int, module: bytes) -> None:
    """Give a shader object its module; its status says whether the driver takes it."""
    with suppress(GLError):
        GL.glShaderBinary(1, np.array([shader], np.uint32), _SPIRV, module, len(module))
        gl_spirv.glSpecializeShaderARB(shader, b"main", 0, None, None)


def link_modules(device: Device, texts: Mapping[str, str], feedback: Sequence[str]) -> SpirvProgram:
    """Link a program of these stages' modules; `feedback` as of `Linker.link`.

    Raises:
        ShaderError: the driver refuses it.
        UnsupportedError: it can't become SPIR-V, or what is to be captured can't.
    """
    shaders = Shaders([])
    stages = [shaders.from_text(texts[s], s, f"<{s}>") for s in _STAGES if texts.get(s)]
    modules, interface = modules_of(stages)
    if feedback:
        last = [stage for stage in modules if stage != "fragment"][-1]
        sizes = {name: _components(interface, name) for name in feedback}
        modules = {**modules, last: with_feedback(modules[last], sizes)}
    program, said = GL.glCreateProgram(), ""
    for stage, module in modules.items():
        shader = GL.glCreateShader(named(f"{stage}_shader"))
        specialise(shader, module)
        if not GL.glGetShaderiv(shader, GL.GL_COMPILE_STATUS):
            said = said or _text(GL.glGetShaderInfoLog(shader))
        GL.glAttachShader(program, shader)
        GL.glDeleteShader(shader)  # when the program is
    if not said:
        with suppress(GLError):
            GL.glLinkProgram(program)
        if not GL.glGetProgramiv(program, GL.GL_LINK_STATUS):
            said = _text(GL.glGetProgramInfoLog(program))
    if said:
        GL.glDeleteProgram(program)
        while GL.glGetError():
            pass
        raise ShaderError(f"the driver refuses the program's SPIR-V: {said}")
    emitted = None
    if "geometry" in modules:
        modes = parse(modules["geometry"]).modes
        emitted = next(named(word) for mode, word in _EMITTED.items() if mode in modes)
    return SpirvProgram(device, program, interface, emitted)


def _text(log: bytes | str) -> str:
    text = log.decode("utf-8", "replace") if isinstance(log, bytes) else log
    return text.strip() or "it does not say why"


def _components(interface: Interface, name: str) -> int:
    """How many numbers a captured output has."""
    if name.startswith("gl_"):
        return {"gl_PointSize": 1}.get(name, 4)
    found = interface.vertex_outputs.get(name)
    if found is not None:
        return found.components * (found.array or 1)
    whole = interface.vertex_outputs[re.sub(r"\[\d+\]$", "", name)]
    return components_of(whole.type) if whole.type[:3] != "mat" else whole.components


@dataclass(frozen=True)
class Attribute:
    """Where a vertex stage reads an attribute, and its `shape`: "f", "i" or "I"."""

    location: int
    shape: str


@dataclass(frozen=True)
class Uniform:
    """A uniform of a program; `dimension` and `array_length` as moderngl has them."""

    program: int
    variable: Variable

    @property
    def location(self) -> int:
        """Where it is."""
        return self.variable.location or 0

    @property
    def dimension(self) -> int:
        """How many numbers one element has."""
        return self.variable.components or 1

    @property
    def array_length(self) -> int:
        """How many elements it has."""
        return self.variable.array or 1

    def write(self, data: bytes) -> None:
        """Upload elements, columns first, by the calls that a program from text gets."""
        kind = self.variable.type
        letter = {"u": "ui", "i": "i", "b": "i", "d": "d"}.get(kind[0], "f")
        values = np.frombuffer(data, _NUMPY[letter])
        count = values.size // self.dimension
        GL.glUseProgram(self.program)
        if "mat" in kind:
            call = getattr(GL, f"glUniformMatrix{kind.partition('mat')[2]}{letter}v")
            call(self.location, count, False, values)
        else:
            call = getattr(GL, f"glUniform{self.dimension}{letter}v")
            call(self.location, count, values)


class SpirvProgram:
    """A linked program, with what the lab uses of a `moderngl.Program`; it is deleted with the
    last reference to it.

    Attributes:
        glo: OpenGL's name.
        geometry_output: what its geometry stage emits, None without one.
    """

    def __init__(
        self, device: Device, glo: int, interface: Interface, geometry_output: int | None
    ) -> None:
        self._context = device.context
        self.glo = glo
        self.geometry_output = geometry_output
        self._interface = interface

    def __del__(self) -> None:
        if self._context.gc_mode == "context_gc":  # see Device.make_current
            self._context.objects.append(self)

    def release(self) -> None:
        """Delete it."""
        GL.glDeleteProgram(self.glo)

    def __contains__(self, name: str) -> bool:
        return self.get(name, None) is not None

    def get(self, name: str, default: Any) -> Uniform | Attribute | Any:
        """An active uniform or attribute."""
        attribute = self._interface.attributes.get(name)
        if attribute is not None and attribute.location in self._active["program_input"]:
            shape = {"i": "i", "u": "I"}.get(attribute.type[0], "f")
            return Attribute(attribute.location or 0, shape)
        uniform = self._interface.uniforms.get(name)
        if uniform is not None and uniform.location in self._active["uniform"]:
            return Uniform(self.glo, uniform)
        return default

    def location(self, name: str) -> int:
        """An active uniform's location, −1 for none."""
        found = self._interface.uniforms.get(name)
        known = found is not None and found.location in self._active["uniform"]
        return found.location or 0 if found is not None and known else -1

    def output(self, name: str) -> int:
        """A fragment output's location, −1 for none."""
        found = self._interface.outputs.get(name)
        return -1 if found is None else found.location or 0

    def block(self, name: str) -> int | None:
        """An active uniform block's index. Its binding is this program's own: another of the same
        vertex stage may number its blocks otherwise."""
        own = self._interface.blocks.get(name)
        return None if own is None else self._blocks.get(own.binding or 0)

    @cached_property
    def _active(self) -> Mapping[str, frozenset[int]]:
        return {kind: frozenset(self._locations(kind)) for kind in ("uniform", "program_input")}

    def _locations(self, kind: str) -> Iterator[int]:
        interface, found = named(kind), np.zeros(1, np.int32)
        GL.glGetProgramInterfaceiv(self.glo, interface, GL.GL_ACTIVE_RESOURCES, found)
        wanted = (ctypes.c_uint * 1)(GL.GL_LOCATION)
        for index in range(int(found[0])):
            got = (ctypes.c_int * 1)()
            GL.glGetProgramResourceiv(self.glo, interface, index, 1, wanted, 1, None, got)
            yield int(got[0])

    @cached_property
    def _blocks(self) -> Mapping[int, int]:
        """The index of each uniform block by the binding that its module gives it."""
        count = int(GL.glGetProgramiv(self.glo, GL.GL_ACTIVE_UNIFORM_BLOCKS))
        found: dict[int, int] = {}
        for index in range(count):
            binding = np.zeros(1, np.int32)
            GL.glGetActiveUniformBlockiv(self.glo, index, GL.GL_UNIFORM_BLOCK_BINDING, binding)
            found[int(binding[0])] = index
        return found
