"""What a program's modules read from outside: their bindings, and buffers and textures for them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.compiler.interface import Block
from shaderlab.compiler.interstage import interface_name
from shaderlab.compiler.module import Decoration, Module, Storage, parse
from shaderlab.compiler.reflection import reflect
from shaderlab.compiler.types import unwrap
from shaderlab.compiler.variables import own_variables
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array

from ..programs import blocks
from .api import NULL, Structs, check, ffi, lib
from .commands import GENERAL
from .memory import Buffer, Resources

SAMPLED, UNIFORM, STORED = 1, 6, 7
"""Kinds of descriptors: a texture with its sampler, a uniform buffer, a storage buffer."""
DEFAULT_BLOCK = "gl_DefaultUniformBlock"
"""The block that uniforms outside of blocks become members of."""
_ALL_GRAPHICS = 0x1F
_MEMBER = re.compile(r"(\w+)(\[\d+\])?\.(\w+)(\[\d+\])?")


@dataclass(frozen=True)
class Binding:
    """A program's binding: its number, the kind and number of its descriptors, and the block that
    a buffer is laid out by."""

    number: int
    kind: int
    count: int = 1
    block: Block | None = None


@dataclass(frozen=True)
class BoundImage:
    """A texture for a binding: its view and its sampler."""

    view: Any
    sampler: Any


def bindings_of(modules: Mapping[str, bytes]) -> dict[str, Binding]:
    """All bindings of a program by the names of blocks and of samplers.

    Raises:
        UnsupportedError: a binding is in another set than the first, or is of another kind.
    """
    blocks = reflect(modules).blocks
    found: dict[str, Binding] = {}
    for data in modules.values():
        module = parse(data)
        for name, id_, storage in _bound(module):
            if module.number(id_, Decoration.DESCRIPTOR_SET):
                raise UnsupportedError(f"{name}: descriptor sets but the first")
            lengths, _ = unwrap(module, module.variables[id_][0])
            block = blocks.get(name)
            kind = SAMPLED if storage == Storage.UNIFORM_CONSTANT else UNIFORM
            if block is not None and block.kind == "storage":
                kind = STORED
            number = module.number(id_, Decoration.BINDING) or 0
            found[name] = Binding(number, kind, lengths[0] if lengths else 1, block)
    return found


def _bound(module: Module) -> Iterator[tuple[str, int, int]]:
    for storage in (Storage.UNIFORM_CONSTANT, Storage.UNIFORM, Storage.STORAGE_BUFFER):
        for id_ in own_variables(module, storage):
            yield interface_name(module, id_), id_, storage
    for id_ in own_variables(module, Storage.PUSH_CONSTANT):
        raise UnsupportedError(f"{interface_name(module, id_)}: push constants have no values here")


def sampler_place(name: str, bindings: Mapping[str, Binding]) -> tuple[Binding, int] | None:
    """The binding and the element of it that a sampler is, by its name in GLSL for OpenGL; None if
    the modules leave it out. One out of a struct was lifted out of it."""
    lifted = _MEMBER.fullmatch(name)
    if lifted is not None:
        owner, first, member, second = (part or "" for part in lifted.groups())
        name = f"{owner}_{member}{first}{second}"
    base, _, index = name.partition("[")
    found = bindings.get(base)
    return None if found is None else (found, int(index.rstrip("]") or 0))


def new_set_layout(resources: Resources, bindings: Mapping[str, Binding]) -> Any:
    """The layout of the set that has all of a program's bindings."""
    structs = Structs()
    each = [
        structs(
            "DescriptorSetLayoutBinding", binding=binding.number, descriptorType=binding.kind,
            descriptorCount=binding.count, stageFlags=_ALL_GRAPHICS,
        )
        for binding in bindings.values()
    ]  # fmt: skip
    info = structs("DescriptorSetLayoutCreateInfo", bindingCount=len(each), pBindings=each)
    return resources.create("DescriptorSetLayout", info)


def new_set(
    resources: Resources,
    layout: Any,
    bindings: Mapping[str, Binding],
    buffers: Mapping[str, Any],
    images: Mapping[str, BoundImage],
) -> Any:
    """A set with these buffers by the names of their blocks, and textures by their samplers' names
    as in OpenGL; NULL if there is nothing to bind."""
    if not bindings:
        return NULL
    structs = Structs()
    sizes = [(binding.kind, binding.count) for binding in bindings.values()]
    pool = resources.create("DescriptorPool", structs(
        "DescriptorPoolCreateInfo", maxSets=1, poolSizeCount=len(sizes), pPoolSizes=sizes
    ))  # fmt: skip
    made = ffi.new("VkDescriptorSet *")
    info = structs(
        "DescriptorSetAllocateInfo", descriptorPool=pool, descriptorSetCount=1, pSetLayouts=[layout]
    )
    check(lib.vkAllocateDescriptorSets(resources.device.handle, info, made), "binding")
    writes = []
    for name, buffer in buffers.items():
        whole = structs("DescriptorBufferInfo", buffer=buffer, range=0xFFFFFFFFFFFFFFFF)
        own = bindings[name]
        writes.append(structs(
            "WriteDescriptorSet", dstSet=made[0], dstBinding=own.number, descriptorCount=1,
            descriptorType=own.kind, pBufferInfo=[whole],
        ))  # fmt: skip
    for name, image in images.items():
        place = sampler_place(name, bindings)
        if place is None:
            continue
        shown = structs(
            "DescriptorImageInfo", sampler=image.sampler, imageView=image.view, imageLayout=GENERAL
        )
        writes.append(structs(
            "WriteDescriptorSet", dstSet=made[0], dstBinding=place[0].number, descriptorCount=1,
            dstArrayElement=place[1], descriptorType=SAMPLED, pImageInfo=[shown],
        ))  # fmt: skip
    changed = structs.array("VkWriteDescriptorSet", writes)
    lib.vkUpdateDescriptorSets(resources.device.handle, len(writes), changed, 0, NULL)
    return made[0]


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
