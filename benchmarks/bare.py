"""The floor: a bare loop over the compilers' functions, with nothing of the lab around it.

It makes the calls that have to be made for three targets, and looks at no message.
"""

from __future__ import annotations

import ctypes as c
from collections.abc import Sequence

from shaderlab.compiler.glslang import Input, SpirvDiagnostic, load_glslang, load_spirv_tools

_STAGES = {"vert": 0, "tesc": 1, "tese": 2, "geom": 3, "frag": 4, "comp": 5}
# client, its version, messages, options, SPIRV-Tools' environment
_TARGETS = ((0, 0, 0, 0, None), (2, 450, 8, 3, 9), (1, 1 << 22, 24, 7, 1))


def compile_all(shaders: Sequence[tuple[str, bytes]]) -> int:
    """Compile texts for all three targets; each comes with its extension. How many were good."""
    lib, tools = load_glslang(), load_spirv_tools()
    front, back = lib.front, lib.back
    contexts = {target[4]: tools.spvContextCreate(target[4]) for target in _TARGETS if target[4]}
    good = 0
    for extension, text in shaders:
        stage = _STAGES[extension]
        for client, version, messages, flags, environment in _TARGETS:
            spirv = (1, 1 << 16) if environment is not None else (0, 0)
            given = Input(1, stage, client, version, *spirv, text, 110, 1, 0, 0, messages)
            given.resource = lib.limits
            shader = front.glslang_shader_create(c.byref(given))
            front.glslang_shader_set_options(shader, flags)
            parsed = front.glslang_shader_preprocess(
                shader, c.byref(given)
            ) and front.glslang_shader_parse(shader, c.byref(given))
            if environment is None:
                good += parsed
                front.glslang_shader_delete(shader)
                continue
            program = front.glslang_program_create()
            if (
                parsed
                and not front.glslang_program_add_shader(program, shader)
                and front.glslang_program_link(program, messages)
                and front.glslang_program_map_io(program)
            ):
                back.glslang_program_SPIRV_generate_with_options(program, stage, None)
                size = 4 * back.glslang_program_SPIRV_get_size(program)
                module = c.string_at(back.glslang_program_SPIRV_get_ptr(program), size)
                said = c.POINTER(SpirvDiagnostic)()
                words = c.cast(c.c_char_p(module), c.c_void_p)
                context = contexts[environment]
                good += not tools.spvValidateBinary(context, words, size // 4, c.byref(said))
                tools.spvDiagnosticDestroy(said)
            front.glslang_program_delete(program)
            front.glslang_shader_delete(shader)
    for context in contexts.values():
        tools.spvContextDestroy(context)
    return good
