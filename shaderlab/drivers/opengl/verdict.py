"""What the driver itself says of a program's GLSL: compiled, and linked where it is whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress

from shaderlab.compiler.driver_verdict import DRIVER, parse_driver_log
from shaderlab.compiler.sources import Source
from shaderlab.errors import DriverError, ShaderError, UnsupportedError
from shaderlab.model.records import Diagnostic, Verdict

from .device import Device
from .linking import Linker, has_names
from .pyopengl import GL, GLError, named

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
        from .spirv_program import modules_of, specialise

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
            found += parse_driver_log(_text(GL.glGetShaderInfoLog(shader)), source, ok=good)
            ok = ok and good
            GL.glAttachShader(program, shader)
        if ok and any(source.stage in _BEGIN for source in sources):
            with suppress(GLError):
                GL.glLinkProgram(program)
            ok = bool(GL.glGetProgramiv(program, GL.GL_LINK_STATUS))
            found += parse_driver_log(_text(GL.glGetProgramInfoLog(program)), sources[-1], ok=ok)
        return Verdict(target=DRIVER, ok=ok, diagnostics=tuple(dict.fromkeys(found)))
    finally:
        GL.glDeleteProgram(program)
        for shader in shaders:
            GL.glDeleteShader(shader)
        while GL.glGetError():
            pass


def verdict_of_linked(linker: Linker, sources: Sequence[Source]) -> Verdict | None:
    """The verdict on a program that the linker links, and keeps, as `driver_verdict` has it; None
    where that is not the same: of a program that is refused, of modules, of some stages only.

    Args:
        linker: of an open device, current in this thread.
        sources: the stages, each once.

    Raises:
        UnsupportedError: as `driver_verdict`.
    """
    _require_stages(linker.device, sources)
    texts = {source.stage: source.text for source in sources}
    if "compute" not in texts and not {"vertex", "fragment"} <= texts.keys():
        return None
    try:
        program = linker.link(texts)
    except ShaderError:
        return None
    if not has_names(program):
        return None
    own = {shader: GL.glGetShaderInfoLog(shader) for shader in GL.glGetAttachedShaders(program.glo)}
    whole = GL.glGetProgramInfoLog(program.glo)
    if not (whole or any(own.values())):  # most often a driver has nothing to say
        return Verdict(target=DRIVER, ok=True)
    by_stage = {GL.glGetShaderiv(shader, GL.GL_SHADER_TYPE): log for shader, log in own.items()}
    logs = [by_stage[named(f"{source.stage}_shader")] for source in sources]
    logs.append(whole)
    found = [
        diagnostic
        for log, source in zip(logs, (*sources, sources[-1]), strict=True)
        for diagnostic in parse_driver_log(_text(log), source, ok=True)
    ]
    return Verdict(target=DRIVER, ok=True, diagnostics=tuple(dict.fromkeys(found)))


def _require_stages(device: Device, sources: Sequence[Source]) -> None:
    for source in sources:
        if device.version < _NEEDS.get(source.stage, 0):
            raise UnsupportedError(f"this driver has no {source.stage} stage", file=source.path)


def _text(log: bytes | str) -> str:
    return log.decode("utf-8", "replace") if isinstance(log, bytes) else log
