"""Calls into glslang: a plain check of one stage, and linked stages to SPIR-V.

Nothing here judges; it hands out logs and modules as glslang wrote them. The plain check goes
through `ShCompile`, whose logs equal the command's; only the newer C interface can link and
make SPIR-V, and its preprocessing step words some syntax errors differently.
"""

from __future__ import annotations

import ctypes as c
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from shaderlab.glsl.library import Glslang, Input, SpirvOptions, glslang
from shaderlab.glsl.sources import STAGES, Source

DEFAULT_VERSION = 110

# glslang_stage_t, in the order of its enumeration.
_STAGE = {
    "vertex": 0,
    "tess_control": 1,
    "tess_evaluation": 2,
    "geometry": 3,
    "fragment": 4,
    "compute": 5,
}
_SPV_RULES, _VULKAN_RULES = 1 << 3, 1 << 4
_MAP_BINDINGS, _MAP_LOCATIONS, _RELAXED = 1 << 0, 1 << 1, 1 << 2
_GLSL, _SPV, _SPV_1_0 = 1, 1, 1 << 16
_MAGIC = (0x07230203).to_bytes(4, sys.byteorder)


@dataclass(frozen=True)
class Environment:
    """What glslang is told of a target: its client, that client's version, rules, options."""

    client: int
    client_version: int
    messages: int
    options: int
    makes_spirv: bool = True


ENVIRONMENTS: Mapping[str, Environment] = {
    "glsl": Environment(0, 0, 0, 0, makes_spirv=False),
    "opengl": Environment(2, 450, _SPV_RULES, _MAP_BINDINGS | _MAP_LOCATIONS),
    "vulkan": Environment(
        1,
        1 << 22,
        _SPV_RULES | _VULKAN_RULES,
        _MAP_BINDINGS | _MAP_LOCATIONS | _RELAXED,
    ),
    "vulkan-strict": Environment(
        1, 1 << 22, _SPV_RULES | _VULKAN_RULES, _MAP_BINDINGS | _MAP_LOCATIONS
    ),
}


@dataclass(frozen=True)
class Checked:
    """The plain verdict on one stage, and the log as the command prints it."""

    ok: bool
    log: str


@dataclass(frozen=True)
class Linked:
    """What linking gave: each stage's parse log, the link's log, and the modules.

    `ok` is glslang's own verdict; `modules` is empty where it is false or the target makes none.
    """

    ok: bool
    stage_logs: Mapping[str, str]
    log: str
    modules: Mapping[str, bytes]


def check(source: Source) -> Checked:
    """One stage under plain GLSL rules."""
    lib = glslang()
    text = source.text.encode()
    compiler = lib.front.ShConstructCompiler(_STAGE[source.stage], 0)
    try:
        ok = lib.front.ShCompile(
            compiler,
            (c.c_char_p * 1)(text),
            1,
            (c.c_int * 1)(len(text)),
            0,
            lib.limits,
            0,
            DEFAULT_VERSION,
            False,
            0,
        )
        return Checked(bool(ok), _text(lib.front.ShGetInfoLog(compiler)))
    finally:
        lib.front.ShDestruct(compiler)


def preprocess(source: Source) -> str | None:
    """The text after glslang's preprocessor, line for line, or None where that fails."""
    lib = glslang()
    handle, given = _create(lib, source, ENVIRONMENTS["glsl"])
    try:
        if not lib.front.glslang_shader_preprocess(handle, c.byref(given)):
            return None
        return _text(lib.front.glslang_shader_get_preprocessed_code(handle))
    finally:
        lib.front.glslang_shader_delete(handle)


def link(sources: Sequence[Source], environment: Environment) -> Linked:
    """All stages parsed, linked and, where the environment makes it, turned into SPIR-V."""
    lib = glslang()
    handles: list[int] = []
    inputs: list[Input] = []  # kept alive until the shaders are deleted
    logs: dict[str, str] = {}
    program = None
    try:
        parsed = True
        for source in sources:
            handle, given = _create(lib, source, environment)
            handles.append(handle)
            inputs.append(given)
            ok = lib.front.glslang_shader_preprocess(handle, c.byref(given))
            ok = ok and lib.front.glslang_shader_parse(handle, c.byref(given))
            logs[source.stage] = _text(lib.front.glslang_shader_get_info_log(handle))
            parsed = parsed and bool(ok)
        if not parsed:
            return Linked(False, logs, "", {})
        program = lib.front.glslang_program_create()
        for handle in handles:
            lib.front.glslang_program_add_shader(program, handle)
        return _linked(lib, program, environment, logs)
    finally:
        # Deleted before its shaders: it may hold what it merged from them.
        if program is not None:
            lib.front.glslang_program_delete(program)
        for handle in handles:
            lib.front.glslang_shader_delete(handle)


def _linked(
    lib: Glslang, program: int, environment: Environment, logs: Mapping[str, str]
) -> Linked:
    ok = bool(lib.front.glslang_program_link(program, environment.messages))
    if ok and environment.makes_spirv:
        ok = bool(lib.front.glslang_program_map_io(program))
    log = _text(lib.front.glslang_program_get_info_log(program))
    if not (ok and environment.makes_spirv):
        return Linked(ok, logs, log, {})
    modules, notes = _generate(lib, program, sorted(logs, key=STAGES.index))
    return Linked(True, logs, log + notes, modules)


def _create(lib: Glslang, source: Source, environment: Environment) -> tuple[int, Input]:
    given = Input(
        language=_GLSL,
        stage=_STAGE[source.stage],
        client=environment.client,
        client_version=environment.client_version,
        target_language=_SPV if environment.makes_spirv else 0,
        target_language_version=_SPV_1_0 if environment.makes_spirv else 0,
        code=source.text.encode(),
        default_version=DEFAULT_VERSION,
        default_profile=1,  # none
        messages=environment.messages,
        resource=lib.limits,
    )
    handle: int = lib.front.glslang_shader_create(c.byref(given))
    lib.front.glslang_shader_set_options(handle, environment.options)
    return handle, given


def _generate(lib: Glslang, program: int, stages: Sequence[str]) -> tuple[Mapping[str, bytes], str]:
    """Each stage's module, and what the generator has to say about them."""
    options = SpirvOptions(validate=False)
    modules, notes, before = {}, "", 0
    for stage in stages:
        lib.back.glslang_program_SPIRV_generate_with_options(
            program, _STAGE[stage], c.byref(options)
        )
        size = 4 * lib.back.glslang_program_SPIRV_get_size(program)
        data = c.string_at(lib.back.glslang_program_SPIRV_get_ptr(program), size)
        # glslang 13 appends each stage's module to those made before from the same program.
        modules[stage] = data[before:] if data.startswith(_MAGIC, before) else data
        notes += _text(lib.back.glslang_program_SPIRV_get_messages(program))
        before = size
    return modules, notes


def _text(raw: bytes | None) -> str:
    return "" if raw is None else raw.decode("utf-8", "replace")
