"""Linking programs on the driver, from text or from SPIR-V modules; their outputs and uniforms."""

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
from shaderlab.compiler.module_edits import add_feedback
from shaderlab.compiler.reflection import Interface, Variable
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.compiler.spirv import parse
from shaderlab.errors import Diagnostic, DriverError, ShaderError, UnsupportedError, Verdict
from shaderlab.model.frame import Array
from shaderlab.model.phases import phase

from ..programs.textures import components_of
from ..resources import ProgramCache
from .device import GL, Device, GLError, gl_constant, gl_spirv

_STAGES = ("vertex", "tess_control", "tess_evaluation", "geometry", "fragment", "compute")
# The OpenGL version that has each stage.
LEAST_VERSIONS = {"tess_control": 400, "tess_evaluation": 400, "compute": 430}
# A driver links a program only from a stage that begins one.
_BEGIN = ("vertex", "compute")
_NUMPY = {"ui": np.uint32, "i": np.int32, "d": np.float64, "f": np.float32}
# What the strips of geometry stages are made of, by execution mode (SPIR-V: OutputPoints,
# OutputLineStrip, OutputTriangleStrip).
_EMITTED = {27: "points", 28: "lines", 29: "triangles"}


class Linker(ProgramCache[Any]):
    """Linked programs by their stages' text; a driver that `takes_spirv` gets the modules of it."""

    device: Device

    def drop(self, program: Any) -> None:
        """Leave it to moderngl, which releases it when nothing refers to it any more."""

    def link(self, stages: Mapping[str, str], *, feedback: Sequence[str] = ()) -> Any:
        """Link a `moderngl.Program` of these stages (text by "vertex", "tess_control", …), a
        `moderngl.ComputeShader` of "compute", or a `SpirvProgram`, which can do what the lab needs
        of them.

        `feedback` are the vertex outputs to be captured by transform feedback. Raises ShaderError:
        the driver refuses the program."""

        def link() -> Any:
            try:
                with phase("link"):
                    return self._link(stages, feedback)
            except moderngl.Error as error:
                message = f"the driver refuses the program: {str(error).strip()}"
                raise ShaderError(message) from error

        return self.get((tuple(sorted(stages.items())), tuple(feedback)), link)

    def _link(self, stages: Mapping[str, str], feedback: Sequence[str]) -> Any:
        if self.device.takes_spirv:
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
    """Find where a linked program has a uniform; −1 for none."""
    if not has_names(program):
        return int(program.location(name))
    return int(GL.glGetUniformLocation(program.glo, name.encode()))


def output_locations(program: Any, names: Iterable[str]) -> dict[str, int]:
    """Find where the linked program writes each of its fragment outputs; −1 for one it has not."""
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
            set_unlocated(program, array)
            continue
        matrix = array.ndim >= 2 and array.shape[-2] * array.shape[-1] == member.dimension
        data = np.ascontiguousarray(np.swapaxes(array, -1, -2) if matrix else array)
        count = getattr(member, "array_length", 1)
        member.write(data.reshape(-1)[: count * member.dimension].tobytes())
    return inactive


def set_unlocated(program: Any, array: Array) -> None:
    """Set a uniform that has no location, by the function for its type."""
    GL.glUseProgram(program.glo)
    kind = {"f": "f", "u": "ui"}.get(array.dtype.kind, "i")
    array = np.ascontiguousarray(array, _NUMPY[kind])
    if array.ndim >= 2 and kind == "f":
        rows, columns = array.shape[-2:]
        if 2 <= rows <= 4 and 2 <= columns <= 4:
            size = str(rows) if rows == columns else f"{columns}x{rows}"
            getattr(GL, f"glUniformMatrix{size}fv")(-1, 1, False, np.swapaxes(array, -1, -2).copy())
            return
    components = array.shape[-1] if array.ndim and array.shape[-1] <= 4 else 1
    getattr(GL, f"glUniform{components}{kind}v")(-1, array.size // components, array)


# Programs made of shader objects: of modules, and for verdicts.


def modules_of(stages: Sequence[Source]) -> tuple[Mapping[str, bytes], Interface]:
    """Compile a program to modules for OpenGL by stage; returns its interface, too. Raises
    UnsupportedError: it can't become SPIR-V."""
    compiled = cached_compiler()(stages, ("glsl", "opengl"))
    try:
        compiled.require()
    except ShaderError as error:
        message = f"it has no SPIR-V module for OpenGL: {error.message}"
        raise UnsupportedError(message, file=error.file, line=error.line) from error
    assert compiled.interface is not None
    return compiled.spirv["opengl"], compiled.interface


def compile_shader(program: int, stage: str, content: str | bytes) -> tuple[bool, str]:
    """Compile a stage from its text or its module, and attach it to a program, with which it is
    deleted. Returns whether the driver takes it, and what it says."""
    shader = GL.glCreateShader(gl_constant(f"{stage}_shader"))
    with suppress(GLError):  # the status says it
        if isinstance(content, str):
            GL.glShaderSource(shader, content)
            GL.glCompileShader(shader)
        else:
            names = np.array([shader], np.uint32)
            kind = GL.GL_SHADER_BINARY_FORMAT_SPIR_V
            GL.glShaderBinary(1, names, kind, content, len(content))
            gl_spirv.glSpecializeShaderARB(shader, b"main", 0, None, None)
    taken = bool(GL.glGetShaderiv(shader, GL.GL_COMPILE_STATUS))
    log = _decode_log(GL.glGetShaderInfoLog(shader))
    GL.glAttachShader(program, shader)
    GL.glDeleteShader(shader)
    return taken, log


def link_program(program: int) -> tuple[bool, str]:
    """Link a program; returns whether the driver takes it, and what it says."""
    with suppress(GLError):
        GL.glLinkProgram(program)
    linked = bool(GL.glGetProgramiv(program, GL.GL_LINK_STATUS))
    return linked, _decode_log(GL.glGetProgramInfoLog(program))


def _decode_log(log: bytes | str) -> str:
    return log.decode("utf-8", "replace") if isinstance(log, bytes) else log


def driver_verdict(device: Device, sources: Sequence[Source]) -> Verdict:
    """Ask the driver for its verdict on a program, as a target named "driver". Each stage is
    compiled; all are linked where the program has a stage that begins one. Nothing stays behind in
    the context. Raises UnsupportedError: the driver has no such stage."""
    for source in sources:
        if device.version < LEAST_VERSIONS.get(source.stage, 0):
            raise UnsupportedError(f"this driver has no {source.stage} stage", file=source.path)
    modules: Mapping[str, bytes] = {}
    if device.takes_spirv:
        try:
            modules = modules_of(sources)[0]
        except UnsupportedError as error:
            raise DriverError(error.message, file=error.file, line=error.line) from error
    diagnostics: list[Diagnostic] = []
    ok = True
    program = GL.glCreateProgram()
    try:
        for source in sources:
            content = modules.get(source.stage, source.text)
            taken, log = compile_shader(program, source.stage, content)
            diagnostics += parse_driver_log(log, source, ok=taken)
            ok = ok and taken
        if ok and any(source.stage in _BEGIN for source in sources):
            ok, log = link_program(program)
            diagnostics += parse_driver_log(log, sources[-1], ok=ok)
    finally:
        GL.glDeleteProgram(program)
        while GL.glGetError():
            pass
    return Verdict(target=DRIVER, ok=ok, diagnostics=tuple(dict.fromkeys(diagnostics)))


def link_modules(
    device: Device, texts: Mapping[str, str], feedback: Sequence[str]
) -> "SpirvProgram":
    """Link a program of these stages' modules; `feedback` as of `Linker.link`. Raises ShaderError:
    the driver refuses it; UnsupportedError: it can't become SPIR-V, or what is to be captured
    can't."""
    shaders = Shaders([])
    stages = [shaders.from_text(texts[s], s, f"<{s}>") for s in _STAGES if texts.get(s)]
    modules, interface = modules_of(stages)
    if feedback:
        last = [stage for stage in modules if stage != "fragment"][-1]
        sizes = {name: _count_components(interface, name) for name in feedback}
        modules = {**modules, last: add_feedback(modules[last], sizes)}
    program = GL.glCreateProgram()
    results = [compile_shader(program, stage, module) for stage, module in modules.items()]
    if all(taken for taken, _ in results):
        results = [link_program(program)]
    refusals = [log for taken, log in results if not taken]
    if refusals:
        GL.glDeleteProgram(program)
        while GL.glGetError():
            pass
        reason = refusals[0].strip() or "it does not say why"
        raise ShaderError(f"the driver refuses the program's SPIR-V: {reason}")
    emitted = None
    if "geometry" in modules:
        modes = parse(modules["geometry"]).modes
        emitted = next(gl_constant(word) for mode, word in _EMITTED.items() if mode in modes)
    return SpirvProgram(device, program, interface, emitted)


def _count_components(interface: Interface, name: str) -> int:
    if name.startswith("gl_"):
        return {"gl_PointSize": 1}.get(name, 4)
    variable = interface.vertex_outputs.get(name)
    if variable is not None:
        return variable.components * (variable.array or 1)
    whole = interface.vertex_outputs[re.sub(r"\[\d+\]$", "", name)]
    return components_of(whole.type) if whole.type[:3] != "mat" else whole.components


@dataclass(frozen=True)
class Attribute:
    """Where a vertex stage reads an attribute, and its `shape`: "f", "i" or "I"."""

    location: int
    shape: str


@dataclass(frozen=True)
class Uniform:
    """A uniform of a program; `dimension` is how many numbers one element has, as in moderngl."""

    program: int
    variable: Variable

    @property
    def dimension(self) -> int:
        return self.variable.components or 1

    @property
    def array_length(self) -> int:
        return self.variable.array or 1

    def write(self, data: bytes) -> None:
        """Upload elements, columns first, by the calls that a program from text gets."""
        kind, location = self.variable.type, self.variable.location or 0
        letter = {"u": "ui", "i": "i", "b": "i", "d": "d"}.get(kind[0], "f")
        values = np.frombuffer(data, _NUMPY[letter])
        count = values.size // self.dimension
        GL.glUseProgram(self.program)
        if "mat" in kind:
            call = getattr(GL, f"glUniformMatrix{kind.partition('mat')[2]}{letter}v")
            call(location, count, False, values)
        else:
            call = getattr(GL, f"glUniform{self.dimension}{letter}v")
            call(location, count, values)


@dataclass(eq=False)
class SpirvProgram:
    """A linked program, with what the lab uses of a `moderngl.Program`; it is deleted with the
    last reference to it. `glo` is OpenGL's name, `geometry_output` what a geometry stage emits."""

    device: Device
    glo: int
    interface: Interface
    geometry_output: int | None

    def __del__(self) -> None:
        if self.device.context.gc_mode == "context_gc":  # see Device.make_current
            self.device.context.objects.append(self)

    def release(self) -> None:
        GL.glDeleteProgram(self.glo)

    def __contains__(self, name: str) -> bool:
        return self.get(name, None) is not None

    def get(self, name: str, default: Any) -> Uniform | Attribute | Any:
        attribute = self.interface.attributes.get(name)
        if attribute is not None and attribute.location in self._active["program_input"]:
            shape = {"i": "i", "u": "I"}.get(attribute.type[0], "f")
            return Attribute(attribute.location or 0, shape)
        uniform = self.interface.uniforms.get(name)
        if uniform is not None and uniform.location in self._active["uniform"]:
            return Uniform(self.glo, uniform)
        return default

    def location(self, name: str) -> int:
        """Find an active uniform's location, −1 for none."""
        found = self.get(name, None)
        return found.variable.location or 0 if isinstance(found, Uniform) else -1

    def output(self, name: str) -> int:
        """Find a fragment output's location, −1 for none."""
        output = self.interface.outputs.get(name)
        return -1 if output is None else output.location or 0

    def block(self, name: str) -> int | None:
        """Find an active uniform block's index. Its binding is this program's own: another of the
        same vertex stage may number its blocks otherwise."""
        block = self.interface.blocks.get(name)
        return None if block is None else self._blocks.get(block.binding or 0)

    @cached_property
    def _blocks(self) -> Mapping[int, int]:
        """The index of each uniform block by the binding that its module gives it, which is read
        before the lab gives them others."""
        indices: dict[int, int] = {}
        binding = np.zeros(1, np.int32)
        for index in range(int(GL.glGetProgramiv(self.glo, GL.GL_ACTIVE_UNIFORM_BLOCKS))):
            GL.glGetActiveUniformBlockiv(self.glo, index, GL.GL_UNIFORM_BLOCK_BINDING, binding)
            indices[int(binding[0])] = index
        return indices

    @cached_property
    def _active(self) -> Mapping[str, frozenset[int]]:
        return {kind: frozenset(self._locations(kind)) for kind in ("uniform", "program_input")}

    def _locations(self, kind: str) -> Iterator[int]:
        interface, count = gl_constant(kind), np.zeros(1, np.int32)
        GL.glGetProgramInterfaceiv(self.glo, interface, GL.GL_ACTIVE_RESOURCES, count)
        for index in range(int(count[0])):
            yield read_resource(self.glo, interface, index, GL.GL_LOCATION)


def read_resource(program: int, interface: int, index: int, what: int) -> int:
    """Read one number that a program says of one of its resources."""
    wanted, got = (ctypes.c_uint * 1)(what), (ctypes.c_int * 1)()
    GL.glGetProgramResourceiv(program, interface, index, 1, wanted, 1, None, got)
    return int(got[0])
