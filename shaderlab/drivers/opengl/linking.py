"""Linking programs on the driver, once each; their outputs and uniforms."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import moderngl
import numpy as np

from shaderlab.compiler.compile_cache import cached_compiler
from shaderlab.compiler.diagnostics import DRIVER, parse_driver_log
from shaderlab.compiler.module_edits import with_feedback
from shaderlab.compiler.reflection import Interface, Variable
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.compiler.spirv import parse
from shaderlab.errors import DriverError, ShaderError, UnsupportedError
from shaderlab.model.frame import Array
from shaderlab.model.phases import phase
from shaderlab.model.records import Diagnostic, Verdict

from ..programs.textures import components_of
from ..resources import ProgramCache
from .device import GL, Device, GLError, gl_spirv, named


class Linker(ProgramCache[Any]):
    """Linked programs by their stages' text; a driver that `takes_spirv` gets the modules of it."""

    device: Device

    def drop(self, program: Any) -> None:
        """moderngl releases it when nothing refers to it any more."""

    def link(self, stages: Mapping[str, str], *, feedback: Sequence[str] = ()) -> Any:
        """A `moderngl.Program` of these stages (text by "vertex", "tess_control", …), a
        `moderngl.ComputeShader` of "compute", or a `SpirvProgram`, which can do what the lab needs
        of them.

        `feedback` are the vertex outputs to be captured by transform feedback.

        Raises:
            ShaderError: the driver refuses the program.
        """

        def linked() -> Any:
            try:
                with phase("link"):
                    return self._new(stages, feedback)
            except moderngl.Error as error:
                message = f"the driver refuses the program: {str(error).strip()}"
                raise ShaderError(message) from error

        return self.get((tuple(sorted(stages.items())), tuple(feedback)), linked)

    def _new(self, stages: Mapping[str, str], feedback: Sequence[str]) -> Any:
        if self.device.takes_spirv:
            pass

            return link_modules(self.device, stages, feedback)
        if "compute" in stages:
            return self.device.context.compute_shader(stages["compute"])
        return self.device.context.program(
            vertex_shader=stages["vertex"],
            fragment_shader=stages.get("fragment"),
            tess_control_shader=stages.get("tess_control"),
            tess_evaluation_shader=stages.get("tess_evaluation"),
            geometry_shader=stages.get("geometry"),
            varyings=tuple(feedback),
        )


def has_names(program: Any) -> bool:
    """Whether the driver knows a program's variables by their names: not those of a module."""
    return isinstance(program, moderngl.Program | moderngl.ComputeShader)


def uniform_location(program: Any, name: str) -> int:
    """Where a linked program has a uniform; −1 for none."""
    if not has_names(program):
        return int(program.location(name))
    return int(GL.glGetUniformLocation(program.glo, name.encode()))


def output_locations(program: Any, names: Iterable[str]) -> dict[str, int]:
    """Where the linked program writes each of its fragment outputs; −1 for one it has not."""
    if not has_names(program):
        return {name: program.output(name) for name in names}
    return {name: int(GL.glGetFragDataLocation(program.glo, name.encode())) for name in names}


def set_uniforms(program: Any, values: Mapping[str, Array]) -> list[str]:
    """Upload uniforms; matrices are transposed into GLSL's columns-first order.

    Returns the names that the driver does not know: declared, but with no effect on any output.
    They are set as well, at the location −1, which OpenGL ignores. Members of uniform blocks are no
    uniforms to be set; leave them out.
    """
    inactive = []
    for name, array in values.items():
        member = program.get(name, None)
        if member is None:
            inactive.append(name)
            _set_nowhere(program, array)
            continue
        matrix = member.dimension in (4, 6, 8, 9, 12, 16) and array.ndim >= 2
        data = np.ascontiguousarray(np.swapaxes(array, -1, -2) if matrix else array)
        count = getattr(member, "array_length", 1)
        member.write(data.reshape(-1)[: count * member.dimension].tobytes())
    return inactive


def _set_nowhere(program: Any, array: Array) -> None:
    """Set a uniform that has no location, by the function for its type."""
    GL.glUseProgram(program.glo)
    kind, own = {"f": ("f", np.float32), "u": ("ui", np.uint32)}.get(
        array.dtype.kind, ("i", np.int32)
    )
    array = np.ascontiguousarray(array, own)
    if array.ndim >= 2 and kind == "f":
        rows, columns = array.shape[-2:]
        if 2 <= rows <= 4 and 2 <= columns <= 4:
            size = str(rows) if rows == columns else f"{columns}x{rows}"
            getattr(GL, f"glUniformMatrix{size}fv")(-1, 1, False, np.swapaxes(array, -1, -2).copy())
            return
    components = array.shape[-1] if array.ndim and array.shape[-1] <= 4 else 1
    getattr(GL, f"glUniform{components}{kind}v")(-1, array.size // components, array)


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


_NEEDS = {"tess_control": 400, "tess_evaluation": 400, "compute": 430}
# A driver links a program only from a stage that begins one.
_BEGIN = ("vertex", "compute")


def driver_verdict(device: Device, sources: Sequence[Source]) -> Verdict:
    """The driver's verdict on a program, as a target of its own named "driver".

    Each stage is compiled; all are linked where the program has a stage that begins one. Nothing
    stays behind in the context.

    Args:
        device: an open device, current in this thread.
        sources: the stages, each once.

    Raises:
        UnsupportedError: the driver has no such stage; glslang's verdict is then the only one.
    """
    _require_stages(device, sources)
    modules: Mapping[str, bytes] = {}
    if device.takes_spirv:
        pass

        try:
            modules = modules_of(sources)[0]
        except UnsupportedError as error:
            raise DriverError(error.message, file=error.file, line=error.line) from error
    shaders: list[int] = []
    program = GL.glCreateProgram()
    try:
        found: list[Diagnostic] = []
        ok = True
        for source in sources:
            shader = GL.glCreateShader(named(f"{source.stage}_shader"))
            shaders.append(shader)
            if source.stage in modules:
                specialise(shader, modules[source.stage])
            else:
                GL.glShaderSource(shader, source.text)
                with suppress(GLError):  # the status says it
                    GL.glCompileShader(shader)
            good = bool(GL.glGetShaderiv(shader, GL.GL_COMPILE_STATUS))
            found += parse_driver_log(_text_verdict(GL.glGetShaderInfoLog(shader)), source, ok=good)
            ok = ok and good
            GL.glAttachShader(program, shader)
        if ok and any(source.stage in _BEGIN for source in sources):
            with suppress(GLError):
                GL.glLinkProgram(program)
            ok = bool(GL.glGetProgramiv(program, GL.GL_LINK_STATUS))
            found += parse_driver_log(
                _text_verdict(GL.glGetProgramInfoLog(program)), sources[-1], ok=ok
            )
        return Verdict(target=DRIVER, ok=ok, diagnostics=tuple(dict.fromkeys(found)))
    finally:
        GL.glDeleteProgram(program)
        for shader in shaders:
            GL.glDeleteShader(shader)
        while GL.glGetError():
            pass


def _require_stages(device: Device, sources: Sequence[Source]) -> None:
    for source in sources:
        if device.version < _NEEDS.get(source.stage, 0):
            raise UnsupportedError(f"this driver has no {source.stage} stage", file=source.path)


def _text_verdict(log: bytes | str) -> str:
    return log.decode("utf-8", "replace") if isinstance(log, bytes) else log
