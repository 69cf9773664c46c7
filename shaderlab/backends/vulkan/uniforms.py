"""The buffers that a program's blocks are read from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from shaderlab.backends.vulkan.descriptors import DEFAULT_BLOCK, STORED, UNIFORM, Binding
from shaderlab.backends.vulkan.memory import Buffer, Resources
from shaderlab.compiler.interface import Block
from shaderlab.errors import UnsupportedError
from shaderlab.frame import Array
from shaderlab.programs import blocks

_NONE: Mapping[str, Buffer] = {}


def block_buffers(
    own: Resources,
    bindings: Mapping[str, Binding],
    values: Mapping[str, Array],
    stored: Mapping[str, Buffer] = _NONE,
) -> dict[str, Any]:
    """A buffer's handle for each block.

    Args:
        own: what the buffers are released with.
        bindings: a program's.
        values: uniforms and members of blocks by the names that OpenGL has for them.
        stored: storage buffers by the names of their blocks.

    Raises:
        UnsupportedError: a storage block has no buffer.
    """
    found = {}
    for name, binding in bindings.items():
        if binding.kind == STORED:
            if name not in stored:
                raise UnsupportedError(f"{name}: storage buffers have no values here")
            found[name] = stored[name].handle
        elif binding.kind == UNIFORM:
            assert binding.block is not None
            data = _packed(binding.block, values)
            found[name] = own.buffer("uniform_buffer", data).handle
    return found


def _packed(block: Block, values: Mapping[str, Array]) -> bytes:
    """A block's bytes; what a struct got for the samplers that were lifted out of it is 0."""
    given = dict(values)
    for member in block.members.values():
        if block.name == DEFAULT_BLOCK and member.name not in given:
            given[member.name] = np.zeros(1, np.float32)
    return blocks.packed(block, given)
