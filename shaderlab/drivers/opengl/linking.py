"""Linking programs on the driver, from text or from SPIR-V modules; their outputs and uniforms."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shaderlab.compiler.compile_cache import cached_compiler
from shaderlab.compiler.diagnostics import DRIVER, parse_driver_log
from shaderlab.compiler.reflection import Interface, Variable, add_feedback
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.compiler.spirv import parse
from shaderlab.errors import DriverError, ShaderError, UnsupportedError
from shaderlab.model.frame import Array
from shaderlab.model.phases import phase
from shaderlab.model.records import Diagnostic, Verdict

from ..programs.textures import components_of
from ..resources import ProgramCache
from .device import GL, Device, GLError, c_strings, gl_constant, gl_spirv

_STAGES = ("vertex", "tess_control", "tess_evaluation", "geometry", "fragment", "compute")
# The OpenGL version that has each stage.
_NEEDS = {"tess_control": 400, "tess_evaluation": 400, "compute": 430}
# A driver links a program only from a stage that begins one.
_BEGIN = ("vertex", "compute")
_NUMPY = {"ui": np.uint32, "i": np.int32, "d": np.float64, "f": np.float32}
# Execution modes of geometry stages (SPIR-V), and what their strips are made of.
_OUTPUT_POINTS, _OUTPUT_LINE_STRIP, _OUTPUT_TRIANGLE_STRIP = 27, 28, 29
_EMITTED = {
    _OUTPUT_POINTS: "points",
    _OUTPUT_LINE_STRIP: "lines",
    _OUTPUT_TRIANGLE_STRIP: "triangles",
}


def _list_types() -> Iterator[tuple[int, str]]:
    """Yield OpenGL's number of each GLSL type, and the type."""
    for word in ("float", "int", "unsigned_int", "bool", "double"):
        letter = word[0].replace("f", "")
        yield gl_constant(word), {"unsigned_int": "uint"}.get(word, word)
        yield from ((gl_constant(f"{word}_vec{n}"), f"{letter}vec{n}") for n in (2, 3, 4))
    for word, letter in (("FLOAT", ""), ("DOUBLE", "d")):
        for size in ("2", "3", "4", "2x3", "2x4", "3x2", "3x4", "4x2", "4x3"):
            yield int(getattr(GL, f"GL_{word}_MAT{size}")), f"{letter}mat{size}"


_TYPES = dict(_list_types())


@dataclass(frozen=True)
class Attribute:
    """Where a vertex stage reads an attribute, and its GLSL type."""

    location: int
    type: str


class Program:
    """A linked program.

    Attributes:
        glo: OpenGL's name.
        geometry_output: what its geometry stage emits, None without one.
    """

    def __init__(self, glo: int, geometry_output: int | None) -> None:
        self.glo = glo
        self.geometry_output = geometry_output

    def release(self) -> None:
        """Delete it."""
        GL.glDeleteProgram(self.glo)

    @cached_property
    def _uniforms(self) -> Mapping[str, tuple[int, str]]:
        """Each active uniform's location and type; a sampler is an int."""
        found = {}
        for index in range(int(GL.glGetProgramiv(self.glo, GL.GL_ACTIVE_UNIFORMS))):
            name, _, kind = GL.glGetActiveUniform(self.glo, index)
            location = int(GL.glGetUniformLocation(self.glo, name))
            if location >= 0:  # else it is a member of a block
                spelt = name.decode().removesuffix("[0]")
                found[spelt] = (location, _TYPES.get(int(kind), "int"))
        return found

    def uniform(self, name: str) -> tuple[int, str] | None:
        """Find an active uniform's location and GLSL type."""
        return self._uniforms.get(name)

    def location(self, name: str) -> int:
        """Find an active uniform's location, −1 for none."""
        return (self.uniform(name) or (-1, ""))[0]

    @cached_property
    def _attributes(self) -> Mapping[str, Attribute]:
        found = {}
        for index in range(int(GL.glGetProgramiv(self.glo, GL.GL_ACTIVE_ATTRIBUTES))):
            name, _, kind = GL.glGetActiveAttrib(self.glo, index)
            location = int(GL.glGetAttribLocation(self.glo, name))
            found[name.decode()] = Attribute(location, _TYPES[int(kind)])
        return found

    def attribute(self, name: str) -> Attribute | None:
        """Find an active attribute."""
        return self._attributes.get(name)

    def output(self, name: str) -> int:
        """Find a fragment output's location, −1 for none."""
        return int(GL.glGetFragDataLocation(self.glo, name.encode()))


class SpirvProgram(Program):
    """A program of modules, whose variables the driver does not know by their names."""

    def __init__(self, glo: int, geometry_output: int | None, interface: Interface) -> None:
        super().__init__(glo, geometry_output)
        self._interface = interface

    def uniform(self, name: str) -> tuple[int, str] | None:
        uniform = self._interface.uniforms.get(name)
        if uniform is None or uniform.location not in self._active["uniform"]:
            return None
        return uniform.location or 0, uniform.type

    def attribute(self, name: str) -> Attribute | None:
        attribute = self._interface.attributes.get(name)
        if attribute is None or attribute.location not in self._active["program_input"]:
            return None
        return Attribute(attribute.location or 0, attribute.type)

    def output(self, name: str) -> int:
        output = self._interface.outputs.get(name)
        return -1 if output is None else output.location or 0

    def block(self, name: str) -> int | None:
        """Find an active uniform block's index. Its binding is this program's own: another of the
        same vertex stage may number its blocks otherwise."""
        block = self._interface.blocks.get(name)
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


def set_uniforms(
    program: Program, values: Mapping[str, Array], declared: Mapping[str, Variable]
) -> list[str]:
    """Upload uniforms; matrices are transposed into GLSL's columns-first order.

    Returns the names that the driver does not know: declared, but with no effect on any output.
    They are set as well, at the location −1, which OpenGL ignores. Members of uniform blocks are no
    uniforms to be set; leave them out.
    """
    inactive = []
    if values:
        GL.glUseProgram(program.glo)
    for name, array in values.items():
        found = program.uniform(name)
        if found is None:
            inactive.append(name)
            if name not in declared:
                continue
            found = (-1, declared[name].type)
        _set_uniform(*found, array)
    return inactive


def _set_uniform(location: int, kind: str, array: Array) -> None:
    letter = {"u": "ui", "i": "i", "b": "i", "d": "d"}.get(kind[0], "f")
    matrix = "mat" in kind
    data = np.ascontiguousarray(np.swapaxes(array, -1, -2) if matrix else array, _NUMPY[letter])
    components = components_of(kind)
    count = data.size // components
    if matrix:
        call = getattr(GL, f"glUniformMatrix{kind.partition('mat')[2]}{letter}v")
        call(location, count, False, data.reshape(-1))
    else:
        call = getattr(GL, f"glUniform{components}{letter}v")
        call(location, count, data.reshape(-1))


class Linker(ProgramCache[Program]):
    """Linked programs by their stages' text; a driver that `takes_spirv` gets the modules of it."""

    device: Device

    def link(self, stages: Mapping[str, str], *, feedback: Sequence[str] = ()) -> Program:
        """Link a program of these stages (text by "vertex", "tess_control", …, or "compute").

        `feedback` are the vertex outputs to be captured by transform feedback.

        Raises:
            ShaderError: the driver refuses the program.
            UnsupportedError: it can't become SPIR-V, or what is to be captured can't.
        """

        def link() -> Program:
            with phase("link"):
                own = link_modules if self.device.takes_spirv else link_texts
                return own(stages, feedback)

        return self.get((tuple(sorted(stages.items())), tuple(feedback)), link)


def link_texts(texts: Mapping[str, str], feedback: Sequence[str] = ()) -> Program:
    """Link a program of these stages' texts. Arguments and errors as of `Linker.link`."""
    glo = GL.glCreateProgram()
    if feedback:
        names = c_strings(feedback)
        GL.glTransformFeedbackVaryings(glo, len(feedback), names, GL.GL_INTERLEAVED_ATTRIBS)
    _make_program(glo, texts)
    emitted = None
    if "geometry" in texts:
        emitted = int(GL.glGetProgramiv(glo, GL.GL_GEOMETRY_OUTPUT_TYPE))
        emitted = {GL.GL_LINE_STRIP: GL.GL_LINES, GL.GL_TRIANGLE_STRIP: GL.GL_TRIANGLES}.get(
            emitted, emitted
        )
    return Program(glo, emitted)


def link_modules(texts: Mapping[str, str], feedback: Sequence[str] = ()) -> Program:
    """Link a program of these stages' modules. Arguments and errors as of `Linker.link`."""
    shaders = Shaders([])
    stages = [shaders.from_text(texts[s], s, f"<{s}>") for s in _STAGES if texts.get(s)]
    modules, interface = modules_of(stages)
    if feedback:
        last = [stage for stage in modules if stage != "fragment"][-1]
        sizes = {name: _count_components(interface, name) for name in feedback}
        modules = {**modules, last: add_feedback(modules[last], sizes)}
    glo = GL.glCreateProgram()
    _make_program(glo, modules)
    emitted = None
    if "geometry" in modules:
        modes = parse(modules["geometry"]).modes
        emitted = next(gl_constant(word) for mode, word in _EMITTED.items() if mode in modes)
    return SpirvProgram(glo, emitted, interface)


def _make_program(program: int, stages: Mapping[str, str] | Mapping[str, bytes]) -> None:
    """Compile a program's stages, and link it; it is deleted where the driver refuses it."""
    results = [compile_shader(program, stage, content) for stage, content in stages.items()]
    if all(taken for taken, _ in results):
        results = [link_program(program)]
    refusals = [log for taken, log in results if not taken]
    if refusals:
        GL.glDeleteProgram(program)
        while GL.glGetError():
            pass
        reason = refusals[0].strip() or "it does not say why"
        raise ShaderError(f"the driver refuses the program:\n{reason}")


def modules_of(stages: Sequence[Source]) -> tuple[Mapping[str, bytes], Interface]:
    """Compile a program to modules for OpenGL by stage; returns its interface, too.

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
    """Ask the driver for its verdict on a program, as a target named "driver".

    Each stage is compiled; all are linked where the program has a stage that begins one. Nothing
    stays behind in the context.

    Args:
        device: an open device, current in this thread.
        sources: the stages, each once.

    Raises:
        UnsupportedError: the driver has no such stage; glslang's verdict is then the only one.
    """
    for source in sources:
        if device.version < _NEEDS.get(source.stage, 0):
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


def _count_components(interface: Interface, name: str) -> int:
    if name.startswith("gl_"):
        return {"gl_PointSize": 1}.get(name, 4)
    variable = interface.vertex_outputs.get(name)
    if variable is not None:
        return variable.components * (variable.array or 1)
    whole = interface.vertex_outputs[re.sub(r"\[\d+\]$", "", name)]
    return components_of(whole.type) if whole.type[:3] != "mat" else whole.components
