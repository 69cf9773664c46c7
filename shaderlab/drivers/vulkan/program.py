"""From a program's text to the SPIR-V modules that Vulkan runs.

The text is the one that OpenGL gets, but for what Vulkan counts otherwise: pictures are kept with
their lowest row first, so a point's coordinates run the other way than Vulkan has them, and window
coordinates from the upper corner take the target's height; and a point has the size that its last
stage writes, in Vulkan always.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Block, Variable, own_variables, reflect, stage_variables
from shaderlab.compiler.sources import Source
from shaderlab.compiler.spirv import Decoration, Module, StorageClass, interface_name, parse, unwrap
from shaderlab.errors import UnsupportedError
from shaderlab.model.activity import doing
from shaderlab.model.frame import Array
from shaderlab.model.state import State

from ..programs import blocks
from ..programs.module_texts import compiled_to_modules, counted_as_declared, numbered, sources_of
from ..resources import ProgramCache
from . import state as fixed
from .api import NULL, Structs, check, ffi, lib
from .device import GENERAL, Buffer, Device, Resources
from .images import STENCIL_ASPECT, aspects, vulkan_format
from .vertices import VertexLayout

# Source: SPIR-V Specification 1.6 (Capability) and Vulkan 1.3 Specification, appendix Vulkan
# Environment for SPIR-V: what each capability takes; those without a feature are always there.
_CAPABILITIES = {
    0: "", 1: "", 40: "", 43: "", 44: "", 46: "", 47: "", 49: "", 50: "", 51: "",
    2: "geometryShader", 10: "shaderFloat64", 11: "shaderInt64",
    22: "shaderInt16", 23: "shaderTessellationAndGeometryPointSize",
    24: "shaderTessellationAndGeometryPointSize", 25: "shaderImageGatherExtended",
    27: "shaderStorageImageMultisample", 28: "shaderUniformBufferArrayDynamicIndexing",
    29: "shaderSampledImageArrayDynamicIndexing", 30: "shaderStorageBufferArrayDynamicIndexing",
    31: "shaderStorageImageArrayDynamicIndexing", 32: "shaderClipDistance",
    33: "shaderCullDistance", 34: "imageCubeArray", 35: "sampleRateShading",
    45: "imageCubeArray", 55: "shaderStorageImageReadWithoutFormat",
    56: "shaderStorageImageWriteWithoutFormat", 57: "multiViewport",
}  # fmt: skip
_POINT = re.compile(r"\bgl_PointCoord\b")


def for_vulkan(text: str) -> str:
    """A fragment shader's text as Vulkan is to get it; it may have a uniform HEIGHT more."""
    text = _POINT.sub("vec2(gl_PointCoord.x, 1.0 - gl_PointCoord.y)", text)
    return numbered(counted_as_declared(text))


def modules_of(sources: Sequence[Source]) -> Mapping[str, bytes]:
    """A program's modules by stage.

    Raises:
        ShaderError: it is no GLSL.
        UnsupportedError: it is GLSL, but none that can be made into modules for Vulkan.
    """
    return compiled_to_modules(sources, "vulkan", "Vulkan").spirv["vulkan"]


def check_capabilities(device: Device, modules: Mapping[str, bytes]) -> None:
    """Raise UnsupportedError where a module takes a feature that the device or the lab lacks."""
    for stage, data in modules.items():
        if stage.startswith("tess_"):
            raise UnsupportedError(f"the {stage} stage: the lab tessellates on OpenGL only")
        for number in sorted(parse(data).capabilities):
            feature = _CAPABILITIES.get(number)
            if feature is None:
                raise UnsupportedError(f"the {stage} stage takes SPIR-V capability {number}")
            if feature and feature not in device.features:
                raise UnsupportedError(f"the {stage} stage takes {feature}: this device has none")


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
            if module.number(id_, Decoration.DescriptorSet):
                raise UnsupportedError(f"{name}: descriptor sets but the first")
            lengths, _ = unwrap(module, module.variables[id_][0])
            block = blocks.get(name)
            kind = SAMPLED if storage == StorageClass.UniformConstant else UNIFORM
            if block is not None and block.kind == "storage":
                kind = STORED
            number = module.number(id_, Decoration.Binding) or 0
            found[name] = Binding(number, kind, lengths[0] if lengths else 1, block)
    return found


def _bound(module: Module) -> Iterator[tuple[str, int, int]]:
    for storage in (StorageClass.UniformConstant, StorageClass.Uniform, StorageClass.StorageBuffer):
        for id_ in own_variables(module, storage):
            yield interface_name(module, id_), id_, storage
    for id_ in own_variables(module, StorageClass.PushConstant):
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


_STAGES = {"vertex": 1, "tess_control": 2, "tess_evaluation": 4, "geometry": 8, "fragment": 16}
_VIEWPORT, _SCISSOR = 0, 1


@dataclass(frozen=True)
class Layout:
    """What a pipeline is made for besides its program.

    Attributes:
        vertices: where attributes lie, and the primitive.
        colors: the attachments' formats by location.
        depth: the format of depth and stencil, "" for none.
        samples: how many a pixel has.
        state: the fixed-function state, as `state.in_pipeline` has it.
    """

    vertices: VertexLayout
    colors: tuple[tuple[int, str], ...]
    depth: str
    samples: int
    state: State


class Program:
    """Modules on the device, and a pipeline for each layout that they are drawn with.

    Raises:
        UnsupportedError: the modules take a feature that the device lacks.
    """

    def __init__(self, device: Device, modules: Mapping[str, bytes]) -> None:
        check_capabilities(device, modules)
        self._device = device
        self._resources = Resources(device)
        self.bindings = bindings_of(modules)
        self.attributes = _variables(modules["vertex"], StorageClass.Input)
        self.outputs = (
            _variables(modules["fragment"], StorageClass.Output) if "fragment" in modules else {}
        )
        self.set_layout = new_set_layout(self._resources, self.bindings)
        structs = Structs()
        self.layout = self._resources.create("PipelineLayout", structs(
            "PipelineLayoutCreateInfo", setLayoutCount=1, pSetLayouts=[self.set_layout]
        ))  # fmt: skip
        self._stages = {
            stage: self._resources.create(
                "ShaderModule", structs("ShaderModuleCreateInfo", codeSize=len(code), pCode=code)
            )
            for stage, code in modules.items()
        }
        self.pipeline = functools.cache(self._new_pipeline)

    def release(self) -> None:
        """Release all of it."""
        self._resources.release()

    def locations(self, names: Mapping[str, Any]) -> dict[int, str]:
        """Where the program writes those of its outputs that have these names."""
        return {
            variable.location: name
            for name, variable in self.outputs.items()
            if name in names and variable.location is not None
        }

    def _new_pipeline(self, layout: Layout) -> Any:
        structs = Structs()
        device, colors = self._device, dict(layout.colors)
        count = max(colors, default=-1) + 1
        numbers = [vulkan_format(colors[k]) if k in colors else 0 for k in range(count)]
        depth = vulkan_format(layout.depth) if layout.depth else 0
        stencil = layout.depth and aspects(layout.depth) & STENCIL_ASPECT
        rendering = structs(
            "PipelineRenderingCreateInfo", colorAttachmentCount=count,
            pColorAttachmentFormats=numbers, depthAttachmentFormat=depth,
            stencilAttachmentFormat=depth if stencil else 0,
        )  # fmt: skip
        stages = [
            structs(
                "PipelineShaderStageCreateInfo", stage=_STAGES[stage], module=made, pName="main"
            )
            for stage, made in self._stages.items()
        ]
        clip = structs("PipelineViewportDepthClipControlCreateInfoEXT", negativeOneToOne=1)
        info = structs(
            "GraphicsPipelineCreateInfo", pNext=rendering, stageCount=len(stages), pStages=stages,
            layout=self.layout, pVertexInputState=layout.vertices.input_state(structs),
            pInputAssemblyState=structs(
                "PipelineInputAssemblyStateCreateInfo", topology=layout.vertices.topology
            ),
            pViewportState=structs(
                "PipelineViewportStateCreateInfo", pNext=clip, viewportCount=1, scissorCount=1
            ),
            pRasterizationState=fixed.rasterisation(structs, device, layout.state),
            pMultisampleState=fixed.multisampling(structs, device, layout.state, layout.samples),
            pDepthStencilState=fixed.depth_and_stencil(structs, layout.state),
            pColorBlendState=fixed.blending(structs, layout.state, colors, count),
            pDynamicState=structs(
                "PipelineDynamicStateCreateInfo", dynamicStateCount=2,
                pDynamicStates=[_VIEWPORT, _SCISSOR],
            ),
        )  # fmt: skip
        made = ffi.new("VkPipeline *")
        with doing("link"):
            result = lib.vkCreateGraphicsPipelines(device.handle, NULL, 1, info, NULL, made)
        check(result, "making a pipeline")
        return self._resources.own("Pipeline", made[0])


def _variables(data: bytes, storage: int) -> dict[str, Variable]:
    return {variable.name: variable for variable in stage_variables(parse(data), storage)}


class Linker(ProgramCache[Program]):
    """Programs by their stages' text."""

    device: Device

    def link(self, texts: Mapping[str, str], known: Sequence[Source] = ()) -> Program:
        """The program of these stages.

        Args:
            texts: by stage.
            known: sources, some of whose texts these may be.

        Raises:
            ShaderError: it is no GLSL.
            UnsupportedError: it can't be made into modules for Vulkan, or takes a feature that the
                device lacks.
        """

        def linked() -> Program:
            with doing("compile"):
                modules = modules_of(sources_of(texts, known))
            with doing("link"):
                return Program(self.device, modules)

        return self.get(tuple(sorted(texts.items())), linked)
