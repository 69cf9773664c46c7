"""The engine that calls glslang and SPIRV-Tools in this process, from the wheels' libraries.

Plain checks go through `ShCompile`, whose logs equal the command's. What is linked is parsed by
`TShader::parse`, which preprocesses as it goes, in 0.2 ms however short a text is. Where there is a
message the text is read anew through the C interface, which parses what it has preprocessed: it
words some syntax errors differently.
"""

from __future__ import annotations

import ctypes as c
import functools
import re
import sys
from collections.abc import Mapping, Sequence

from shaderlab.compiler.engines import Checked, Linked
from shaderlab.compiler.library import (
    GLSLANG_WHEEL,
    Glslang,
    Input,
    SpirvOptions,
    files,
    glslang,
    spirv_tools,
)
from shaderlab.compiler.sources import Source
from shaderlab.compiler.spirv_tools import validate
from shaderlab.compiler.targets import SETTINGS, TargetSettings
from shaderlab.compiler.text import STAGES

_DEFAULT_VERSION = 110
_GLSL, _SPV, _SPV_1_0 = 1, 1, 1 << 16
_NO_PROFILE = 1
_MAGIC = (0x07230203).to_bytes(4, sys.byteorder)
# glslang_stage_t has the order of STAGES.
_STAGE = {stage: number for number, stage in enumerate(STAGES)}
_STRING = re.compile(r'"((?:\\.|[^"\\\n])*)"')
_ESCAPED = str.maketrans({"\\": "\\\\", '"': '\\"'})
_CACHED = 8  # a program's stages are checked, and its modules validated, several times in a row


class Library:
    """An `Engine`; see there.

    Raises:
        ShaderError: the libraries are not installed.
    """

    name = "library"

    def __init__(self) -> None:
        self._glslang = glslang()
        spirv_tools()
        self.check = functools.lru_cache(_CACHED)(self._check)
        self.validate = functools.lru_cache(_CACHED)(validate)

    def prepare(self, sources: Sequence[Source]) -> None:
        """Nothing: one by one costs no more."""

    def preprocess(self, source: Source) -> str | None:
        front = self._glslang.front
        handle, input_ = self._create(source, SETTINGS["glsl"], source.text)
        try:
            if not front.glslang_shader_preprocess(handle, c.byref(input_)):
                return None
            return _text(front.glslang_shader_get_preprocessed_code(handle))
        finally:
            front.glslang_shader_delete(handle)

    def link(self, sources: Sequence[Source], target: str, *, lines: bool = False) -> Linked:
        front = self._glslang.front
        settings = SETTINGS[target]
        handles: list[int] = []
        logs: dict[str, str] = {}
        program = None
        try:
            parsed = True
            for source in sources:
                handle, ok, logs[source.stage] = self._parse(source, settings)
                handles.append(handle)
                parsed = parsed and ok
            if not parsed:
                return Linked(False, logs, "", {})
            program = front.glslang_program_create()
            for handle in handles:
                front.glslang_program_add_shader(program, handle)
            return _linked(self._glslang, program, settings, logs, lines)
        finally:
            # Deleted before its shaders: it may hold what it merged from them.
            if program is not None:
                front.glslang_program_delete(program)
            for handle in handles:
                front.glslang_shader_delete(handle)

    def versions(self) -> Mapping[str, str]:
        from importlib.metadata import version  # costs 20 ms, and only `doctor` needs it

        tools = spirv_tools().spvSoftwareVersionString().decode()
        front, *_, back = files()
        return {
            "glslang": version(GLSLANG_WHEEL),
            "glslang library": str(front),
            "SPIRV-Tools": tools.removeprefix("SPIRV-Tools "),
            "SPIRV-Tools library": str(back),
        }

    def _check(self, source: Source) -> Checked:
        front = self._glslang.front
        text = source.text.encode()
        compiler = front.ShConstructCompiler(_STAGE[source.stage], 0)
        try:
            texts, lengths = (c.c_char_p * 1)(text), (c.c_int * 1)(len(text))
            limits = self._glslang.limits
            ok = front.ShCompile(
                compiler, texts, 1, lengths, 0, limits, 0, _DEFAULT_VERSION, False, 0
            )
            return Checked(bool(ok), _text(front.ShGetInfoLog(compiler)))
        finally:
            front.ShDestruct(compiler)

    def _parse(self, source: Source, settings: TargetSettings) -> tuple[int, bool, str]:
        """A shader with what the text has become, whether it is free of errors, and the log."""
        handle = self._parse_at_once(source, settings)
        if handle is not None:
            return handle, True, ""
        front = self._glslang.front
        handle, input_ = self._create(source, settings, _twice_escaped(source.text))
        ok = front.glslang_shader_preprocess(handle, c.byref(input_))
        ok = ok and front.glslang_shader_parse(handle, c.byref(input_))
        return handle, bool(ok), _text(front.glslang_shader_get_info_log(handle))

    def _parse_at_once(self, source: Source, settings: TargetSettings) -> int | None:
        """A shader with what the text has become, or None if there is a message about it."""
        front = self._glslang.front
        handle, input_ = self._create(source, settings, source.text)
        if self._glslang.parse(handle, input_) and not front.glslang_shader_get_info_log(handle):
            return handle
        front.glslang_shader_delete(handle)
        return None

    def _create(self, source: Source, settings: TargetSettings, text: str) -> tuple[int, Input]:
        front, makes_spirv = self._glslang.front, bool(settings.environment)
        input_ = Input(
            language=_GLSL,
            stage=_STAGE[source.stage],
            client=settings.client,
            client_version=settings.client_version,
            target_language=_SPV if makes_spirv else 0,
            target_language_version=_SPV_1_0 if makes_spirv else 0,
            code=text.encode(),
            default_version=_DEFAULT_VERSION,
            default_profile=_NO_PROFILE,
            messages=settings.messages,
            resource=self._glslang.limits,
        )
        handle: int = front.glslang_shader_create(c.byref(input_))
        front.glslang_shader_set_options(handle, settings.options)
        return handle, input_


def _twice_escaped(text: str) -> str:
    """The text with what stands in strings escaped once more: the C interface parses what it has
    preprocessed, in which strings stand without their escapes."""
    if '"' not in text or "\\" not in text:
        return text
    return _STRING.sub(lambda m: f'"{m[1].translate(_ESCAPED)}"', text)


def _linked(
    lib: Glslang, program: int, settings: TargetSettings, logs: Mapping[str, str], lines: bool
) -> Linked:
    makes_spirv = bool(settings.environment)
    ok = bool(lib.front.glslang_program_link(program, settings.messages))
    if ok and makes_spirv:
        ok = bool(lib.front.glslang_program_map_io(program))
    log = _text(lib.front.glslang_program_get_info_log(program))
    if not (ok and makes_spirv):
        return Linked(ok, logs, log, {})
    options = SpirvOptions(generate_debug_info=lines, disable_optimizer=True)
    modules, before = {}, 0
    for stage in sorted(logs, key=STAGES.index):
        lib.back.glslang_program_SPIRV_generate_with_options(
            program, _STAGE[stage], c.byref(options)
        )
        size = 4 * lib.back.glslang_program_SPIRV_get_size(program)
        data = c.string_at(lib.back.glslang_program_SPIRV_get_ptr(program), size)
        # glslang 13 appends each stage's module to those made before from the same program.
        modules[stage] = data[before:] if data.startswith(_MAGIC, before) else data
        log += _text(lib.back.glslang_program_SPIRV_get_messages(program))
        before = size
    return Linked(True, logs, log, modules)


def _text(raw: bytes | None) -> str:
    return "" if raw is None else raw.decode("utf-8", "replace")
