"""Uniform blocks: their members' values, and the bytes that a buffer holds of them.

A block's members lie where glslang puts them, by the std140 rules.
"""

from __future__ import annotations

from collections.abc import Mapping
from operator import attrgetter
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Block, Interface, Member, Variable
from shaderlab.errors import CaseError, UnsupportedError, nearest
from shaderlab.model.frame import Array
from shaderlab.model.scene import Draw, UniformBuffer

from .textures import numpy_type, shape_of

_PLACE = attrgetter("offset", "size", "array_stride", "matrix_stride")


def uniform_blocks(interface: Interface) -> dict[str, Block]:
    """The uniform blocks that a program declares."""
    return {name: block for name, block in interface.blocks.items() if block.kind == "uniform"}


def spelt(block: Block, member: str) -> str:
    """A member's name as OpenGL's interface has it: with the block's name before it where the
    block has an instance name (OpenGL 4.5, §7.3.1), alone where it has none."""
    return f"{block.name}.{member}" if block.instance else member


def variables(interface: Interface) -> dict[str, Variable]:
    """Each member of each uniform block, under the name that OpenGL has for it."""
    return {
        spelt(block, member.name): _variable(spelt(block, member.name), member)
        for block in uniform_blocks(interface).values()
        for member in block.members.values()
    }


def refuse_member(draw: Draw, interface: Interface, name: str) -> None:
    """Raise CaseError where a name that is given as a uniform is that of a block's member."""
    for block in uniform_blocks(interface).values():
        if name in (block.name, block.instance):
            raise CaseError(
                f"{' + '.join(draw.shaders)}: {name!r} is a uniform block, given as a uniform",
                remedy=f"blocks={{{block.name!r}: UniformBuffer(values={{…}})}}",
            )
        for member in block.members:
            if name in (member, f"{block.name}.{member}", f"{block.instance}.{member}"):
                raise CaseError(
                    f"{' + '.join(draw.shaders)}: {name!r} is a member of the uniform block "
                    f"{block.name}, given as a uniform",
                    remedy=f"blocks={{{block.name!r}: UniformBuffer(values={{{member!r}: …}})}}",
                )


def given(draw: Draw, interface: Interface) -> dict[str, Any]:
    """The values that a draw gives for its blocks' members, by the names of `variables`.

    Raises:
        CaseError: a block or a member is missing or unknown.
        UnsupportedError: a block is an array of blocks.
    """
    program = " + ".join(draw.shaders)
    blocks = uniform_blocks(interface)
    for name in draw.blocks:
        if name not in blocks:
            known = nearest(name, blocks) if blocks else "its shaders declare none"
            raise CaseError(f"{program}: there is no uniform block {name!r}", remedy=known)
    values: dict[str, Any] = {}
    for name, block in blocks.items():
        if block.array is not None:
            raise UnsupportedError(
                f"{program}: {name} is an array of uniform blocks",
                remedy="give each block a name of its own, or make its members arrays",
            )
        if name not in draw.blocks:
            raise CaseError(
                f"{program}: nothing is given for the uniform block {name}",
                remedy=f"add blocks={{{name!r}: UniformBuffer(values=…)}} to the draw",
            )
        own = draw.blocks[name].values
        for member in own:
            if member not in block.members:
                raise CaseError(
                    f"{program}: the uniform block {name} has no member {member!r}",
                    remedy=nearest(member, block.members),
                )
        missing = [f"{m.name} ({m.type})" for m in block.members.values() if m.name not in own]
        if missing:
            raise CaseError(
                f"{program}: nothing is given for {', '.join(missing)} of the uniform block {name}",
                remedy="add it to the values of the UniformBuffer",
            )
        values.update({spelt(block, member): value for member, value in own.items()})
    return values


class SharedLayouts:
    """The layouts of buffers that several programs share."""

    def __init__(self) -> None:
        self._first: dict[int, tuple[UniformBuffer, Block]] = {}

    def check(self, source: UniformBuffer, block: Block) -> None:
        """Raise CaseError where a buffer serves another block already, laid out differently."""
        _, first = self._first.setdefault(id(source), (source, block))
        ours, theirs = (
            {name: _PLACE(member) for name, member in one.members.items()} for one in (block, first)
        )
        for name in (*ours, *theirs):
            if ours.get(name) != theirs.get(name):
                raise CaseError(
                    f"one UniformBuffer serves the blocks {first.name} and {block.name}, "
                    f"but {name} does not lie at the same place in both",
                    remedy="declare both blocks alike, or give each a UniformBuffer of its own",
                )


def packed(block: Block, uniforms: Mapping[str, Array]) -> bytes:
    """A block's bytes, all gaps zero; `uniforms` are its members' values as shaders get them."""
    data = bytearray(block.size)
    for member in block.members.values():
        values = uniforms[spelt(block, member.name)]
        whole = values if member.array is not None else values[None]
        placed(member, data, len(whole))[...] = whole
    return bytes(data)


def placed(member: Member, data: bytearray, count: int) -> Array:
    """A member's elements where they lie in a block's bytes: (count, components) or
    (count, rows, columns)."""
    kind = np.dtype(numpy_type(member.type))
    shape = (count, *shape_of(member.type))
    steps: tuple[int, ...] = (kind.itemsize,)
    if len(shape) == 3:  # a matrix is an array of its columns, or of its rows
        steps = (kind.itemsize, member.matrix_stride)
        steps = steps[::-1] if member.row_major else steps
    strides = (member.record_stride or member.array_stride, *steps)
    return np.ndarray(shape, kind, data, member.offset, strides)


def _variable(name: str, member: Member) -> Variable:
    return Variable(name=name, type=member.type, array=member.array, used=True)
