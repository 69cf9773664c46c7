"""Storage blocks: what their members hold before a dispatch, their bytes, what is left in them.

Members lie where glslang puts them, by the rules of the layout that the shader names (std140,
std430).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from shaderlab.compiler.reflection import Block, Interface, Member, Variable
from shaderlab.errors import CaseError, UnsupportedError
from shaderlab.model.frame import Array, Bindings, Fragments, Image
from shaderlab.model.scene import BufferValue, Draw
from shaderlab.model.textures import Output

from . import bind, blocks, images as stored_images, textures
from .textures import Images, find_image

INVOCATION = "gl_GlobalInvocationID"


@dataclass(frozen=True, kw_only=True)
class Slot:
    """A member of a storage block.

    Attributes:
        name: what cases call it: GLSL's name, with the block's before it where two blocks share
            one. Of an array of structs of run-time length it is "particles.position".
        block: the block's name.
        member: where it lies.
    """

    name: str
    block: str
    member: Member

    @property
    def variable(self) -> Variable:
        """What it is; `array` is 0 for one of run-time length."""
        array = 0 if self.member.record_stride else self.member.array
        return Variable(name=self.name, type=self.member.type, array=array)

    @property
    def stride(self) -> int:
        """Bytes from one element to the next."""
        return self.member.record_stride or self.member.array_stride


def storage_blocks(interface: Interface) -> dict[str, Block]:
    """The storage blocks that a program declares."""
    return {name: block for name, block in interface.blocks.items() if block.kind == "storage"}


def slots(interface: Interface) -> dict[str, Slot]:
    """The members of all storage blocks by the names that cases have for them."""
    found = [
        (name, _name(member), member)
        for name, block in storage_blocks(interface).items()
        for member in block.members.values()
    ]
    names = [*(own for _, own, _ in found), *stored_images.declared(interface)]
    spelt = {
        (block, own): own if names.count(own) == 1 else f"{block}.{own}" for block, own, _ in found
    }
    return {
        spelt[block, own]: Slot(name=spelt[block, own], block=block, member=member)
        for block, own, member in found
    }


def _name(member: Member) -> str:
    """A member's name; of an array of structs of run-time length without the first one's index."""
    return member.name.replace("[0]", "", 1) if member.record_stride else member.name


def outputs(interface: Interface) -> dict[str, Variable]:
    """The images and the members of blocks that a program may write, by name."""
    known = slots(interface).values()
    members = {slot.name: slot.variable for slot in known if not slot.member.readonly}
    return {**stored_images.outputs(interface), **members}


def bound(
    draw: Draw, interface: Interface, bindings: Bindings, folder: Path, images: Images
) -> Bindings:
    """A dispatch's bindings with what its storage blocks and its images hold before.

    Args:
        draw: the dispatch.
        interface: what its program declares.
        bindings: its uniforms and textures.
        folder: where paths of image files begin.
        images: what earlier passes gave.

    Raises:
        CaseError: what is given for a member or an image is missing, unknown, or of the wrong type
            or shape.
        AssetError: an image file can't be read.
    """
    known = slots(interface)
    bind.compare("buffer", draw, draw.buffers, {n: s.variable for n, s in known.items()})
    exact, decimal = {}, {}
    for name, value in draw.buffers.items():
        exact[name], decimal[name] = _values(known[name], value, images)
    for block in storage_blocks(interface):
        lengths = {
            name: len(exact[name])
            for name, slot in known.items()
            if slot.block == block and slot.member.record_stride
        }
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{count} for {name}" for name, count in lengths.items())
            raise CaseError(
                f"{draw.compute}: one array of structs has one length, but there are {listed}"
            )
    arrays = {name for name, slot in known.items() if slot.variable.array is not None}
    return replace(
        bindings,
        buffers=exact,
        images=stored_images.bound(draw, interface, folder, images),
        decimal={**bindings.decimal, **decimal},
        arrays=bindings.arrays | arrays,
    )


def require_supported(draw: Draw, interface: Interface) -> None:
    """Check that the lab can give a compute shader what it declares, and read what it writes.

    Raises:
        UnsupportedError: it can't; names what is declared.
        CaseError: the shader writes nothing.
    """
    for name, variable in interface.uniforms.items():
        if variable.type == "atomic_uint":
            raise UnsupportedError(
                f"{draw.compute}: {name} is an atomic_uint",
                remedy="declare a uint in a buffer block instead, or an r32ui image",
            )
    stored_images.require_supported(draw, interface)
    for name, block in storage_blocks(interface).items():
        if block.array is not None:
            raise UnsupportedError(f"{draw.compute}: {name} is an array of storage blocks")
    for slot in slots(interface).values():
        member = slot.member
        if member.record_stride and member.array is not None:
            raise UnsupportedError(
                f"{draw.compute}: {slot.name} is an array in an array of run-time length"
            )
        if not member.type.endswith(("float", "int", "uint", "2", "3", "4")) or (
            member.type.startswith("d")
        ):
            raise UnsupportedError(f"{draw.compute}: {slot.name} is {member.type}")
    if not outputs(interface):
        raise CaseError(
            f"{draw.compute} writes to no storage block and no image, so nothing could be checked"
        )


def _values(slot: Slot, value: BufferValue, images: Images) -> tuple[Array, Array]:
    """What a member holds, as the shader gets it and as written, in the shapes of uniforms."""
    variable = slot.variable
    if isinstance(value, Output):
        value = _left(variable, find_image(value, images), value)
    if variable.array == 0:
        count = len(value) if isinstance(value, list | tuple) else (*np.shape(value), 0)[0]
        if not count:
            raise CaseError(f"buffer {slot.name!r} is {variable.type}[]: it takes an array")
        variable = replace(variable, array=count)
    return bind.value_arrays(variable, value, "buffer")


def _left(variable: Variable, image: Image, source: Output) -> Array:
    """What an earlier pass left, in the shape that a member takes."""
    shape = textures.shape_of(variable.type)
    wanted, found = np.dtype(textures.numpy_type(variable.type)), image.values.dtype
    if image.values.shape[-1] != shape[0] or found != wanted:
        raise CaseError(
            f"buffer {variable.name!r} is {variable.type}, but {source.path} has "
            f"{image.values.shape[-1]} components of {found}"
        )
    if len(shape) == 2:  # a pixel for each column
        values = image.values.reshape(-1, shape[1], shape[0]).swapaxes(1, 2)
    else:
        values = image.values.reshape(-1, *shape)
    return values if variable.array is not None else values[0]


def packed(block: Block, members: Mapping[str, Slot], values: Mapping[str, Array]) -> bytearray:
    """A block's bytes, all gaps zero. An array of run-time length ends where its elements do, so
    that its `length()` is theirs.

    Args:
        block: the block.
        members: its members by name.
        values: what they hold, as of `bound`.
    """
    open_ended = [n for n, s in members.items() if s.variable.array == 0]
    size = block.size
    if open_ended:
        start = min(members[name].member.offset for name in open_ended)
        size = start + len(values[open_ended[0]]) * members[open_ended[0]].stride
    data = bytearray(size)
    for name, slot in members.items():
        whole = values[name] if slot.variable.array is not None else values[name][None]
        blocks.placed(slot.member, data, len(whole))[...] = whole
    return data


def unpacked(slot: Slot, data: bytearray, like: Array) -> Array:
    """What a member holds in a block's bytes, in the shape of what it held before."""
    count = len(like) if slot.variable.array is not None else 1
    return blocks.placed(slot.member, data, count).reshape(like.shape).copy()


def image_of(slot: Slot, values: Array) -> Image:
    """A member as an image of one row: a pixel for each element, of a matrix for each column."""
    whole = values if slot.variable.array is not None else values[None]
    letter = {"i": "i", "u": "u"}.get(slot.member.type[0], "")
    if whole.ndim == 3:
        whole = whole.swapaxes(1, 2).reshape(-1, whole.shape[1])
    kind = f"{letter}vec{whole.shape[1]}" if whole.shape[1] > 1 else slot.member.type
    return Image(np.ascontiguousarray(whole[None]), textures.for_output(kind))


def captured(draw: Draw, interface: Interface, bindings: Bindings) -> Fragments:
    """What the invocations of a dispatch got: the contents of its storage blocks before, a pixel
    for each element, and the invocations' own numbers, x first: a column for each x, a row for each
    y, one z above the other."""
    local = interface.local_size or (1, 1, 1)
    sizes = [groups * size for groups, size in zip(draw.groups, local, strict=True)]
    z, y, x = np.indices(sizes[::-1], np.uint32).reshape(3, -1, sizes[0])
    inputs = {INVOCATION: np.stack([x, y, z], axis=-1), **dict(_elements(bindings))}
    covered = np.ones(x.shape, bool)
    return Fragments(covered=covered, frag_coord=np.zeros((*x.shape, 4)), inputs=inputs)


def _elements(bindings: Bindings) -> Iterator[tuple[str, Array]]:
    for name, values in bindings.buffers.items():
        yield name, values[None] if name in bindings.arrays else values[None, None]
