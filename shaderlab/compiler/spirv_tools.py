"""SPIR-V modules as a whole: validation and disassembly by SPIRV-Tools, and their size."""

from __future__ import annotations

import ctypes as c
import functools
import sys
from collections.abc import Mapping

from shaderlab.compiler.library import SpirvDiagnostic, SpirvText, spirv_tools
from shaderlab.errors import ShaderError, nearest

# spv_target_env.
_ENVIRONMENTS: Mapping[str, int] = {
    "spv1.0": 0,
    "vulkan1.0": 1,
    "opengl4.5": 9,
    "vulkan1.1": 18,
    "vulkan1.2": 23,
    "vulkan1.3": 25,
}
_NO_HEADER, _INDENT, _FRIENDLY_NAMES = 1 << 5, 1 << 3, 1 << 6


def validate(module: bytes, env: str) -> str | None:
    """SPIRV-Tools' message about an invalid module, or None if it is valid.

    Args:
        module: SPIR-V as bytes, four a word.
        env: "opengl4.5", "vulkan1.0" … "vulkan1.3" or "spv1.0".

    Raises:
        ShaderError: no such environment, or the library is missing.
    """
    if env not in _ENVIRONMENTS:
        raise ShaderError(
            f"no such SPIR-V environment: {env!r}", remedy=nearest(env, _ENVIRONMENTS)
        )
    tools = spirv_tools()
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
    """The module as SPIR-V assembly with readable names.

    Raises:
        ShaderError: the bytes are not a SPIR-V module, or the library is missing.
    """
    if len(module) % 4:
        raise ShaderError(f"not a SPIR-V module: {len(module)} bytes are no whole words")
    tools = spirv_tools()
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


def instruction_count(module: bytes) -> int:
    """The number of a module's instructions.

    Raises:
        ShaderError: the bytes are not a SPIR-V module.
    """
    if len(module) < 20 or len(module) % 4:
        raise ShaderError(f"not a SPIR-V module: {len(module)} bytes")
    # An instruction's first word has its length in the upper half; a list is read fastest.
    upper = 1 if sys.byteorder == "little" else 0
    lengths = memoryview(module).cast("H")[upper::2].tolist()
    at, end = 5, len(lengths)
    for count in range(end):
        if at >= end:
            return count
        at += lengths[at]
    # An instruction of length 0: the loop did not advance.
    raise ShaderError(f"not a SPIR-V module: broken instruction at word {at}")


@functools.cache
def _context(env: str) -> int:
    """A context for the environment. It is never written to, so all calls and threads share it."""
    context: int = spirv_tools().spvContextCreate(_ENVIRONMENTS[env])
    return context
