"""Expectations of where things lie in memory, read back from OpenGL."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from shaderlab.errors import CaseError


@dataclass(frozen=True, kw_only=True)
class AttributeLayout:
    """Each attribute lies at (offset, stride, divisor) in its buffer, as OpenGL itself says."""

    attributes: Mapping[str, tuple[int, int, int]]
    pass_name: str | None = None
    draw: int = -1
    name: str = ""


@dataclass(frozen=True, kw_only=True)
class BlockLayout:
    """A uniform block's members lie at these offsets, for the lab and for the driver."""

    block: str
    offsets: Mapping[str, int]
    size: int | None
    pass_name: str | None = None
    draw: int = -1
    name: str = ""


def attribute_layout(
    attributes: Mapping[str, Sequence[int]],
    *,
    pass_name: str | None = None,
    draw: int = -1,
    name: str = "memory layout",
) -> AttributeLayout:
    """OpenGL reads each attribute at (offset, stride) or (offset, stride, divisor), in bytes.

    It is asked for GL_VERTEX_ATTRIB_ARRAY_POINTER, _STRIDE and _DIVISOR; a matrix is read where
    its first column is.

    Raises:
        CaseError: an entry has neither two nor three numbers.
    """
    placed = {}
    for attribute, entry in attributes.items():
        if len(entry) not in (2, 3):
            raise CaseError(
                f"attribute_layout: {attribute!r} takes (offset, stride) or "
                f"(offset, stride, divisor), not {entry!r}"
            )
        offset, stride, divisor = (*entry, 0)[:3]
        placed[attribute] = (offset, stride, divisor)
    return AttributeLayout(attributes=placed, pass_name=pass_name, draw=draw, name=name)


def block_layout(
    block: str,
    offsets: Mapping[str, int],
    *,
    size: int | None = None,
    pass_name: str | None = None,
    draw: int = -1,
    name: str = "",
) -> BlockLayout:
    """The members of a uniform block lie at these offsets, and it takes `size` bytes.

    Members are named as in `UniformBuffer`. Both the lab's layout and the driver's are judged;
    drivers may say that a block is larger than it need be, but not that it is smaller.
    """
    return BlockLayout(
        block=block,
        offsets=dict(offsets),
        size=size,
        pass_name=pass_name,
        draw=draw,
        name=name or f"layout of {block}",
    )
