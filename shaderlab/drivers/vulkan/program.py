"""Programs of SPIR-V modules: what they bind, and a pipeline for each layout they are drawn with.

Pictures lie in memory with their lowest row first, as in OpenGL, and nothing is flipped: Vulkan
takes that row for the upper one, so that what it calls clockwise is counter-clockwise to OpenGL.
"""

import functools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from shaderlab.compiler.reflection import Block, Variable, own_variables, reflect, stage_variables
from shaderlab.compiler.sources import Source
from shaderlab.compiler.spirv import (
    Capability,
    Decoration,
    Module,
    StorageClass,
    interface_name,
    parse,
    unwrap,
)
from shaderlab.errors import UnsupportedError
from shaderlab.model.mesh import PRIMITIVES
from shaderlab.model.phases import phase
from shaderlab.model.state import (
    BLEND_EQUATIONS,
    BLEND_FACTORS,
    COMPARISONS,
    STENCIL_OPERATIONS,
    Blend,
    Depth,
    Rectangle,
    State,
    Stencil,
)

from ..programs import module_texts
from ..programs.textures import COLOR
from ..resources import ProgramCache
from .device import NULL, Device, Resources, Structs, check, constant, ffi, lib
from .images import STENCIL_ASPECT, aspects, vulkan_format

# Source: SPIR-V Specification 1.6 (Capability) and Vulkan 1.3 Specification, appendix Vulkan
# Environment for SPIR-V: the capabilities that are always there, and the features that the others
# take where these are not called "shader" and the capability's name.
_ALWAYS = frozenset([
    Capability.Matrix, Capability.Shader, Capability.InputAttachment, Capability.Sampled1D,
    Capability.Image1D, Capability.SampledBuffer, Capability.ImageBuffer,
    Capability.StorageImageExtendedFormats, Capability.ImageQuery, Capability.DerivativeControl,
])  # fmt: skip
_FEATURES: dict[int, str] = {
    Capability.Geometry: "geometryShader",
    Capability.TessellationPointSize: "shaderTessellationAndGeometryPointSize",
    Capability.GeometryPointSize: "shaderTessellationAndGeometryPointSize",
    Capability.ImageCubeArray: "imageCubeArray",
    Capability.SampledCubeArray: "imageCubeArray",
    Capability.SampleRateShading: "sampleRateShading",
    Capability.MultiViewport: "multiViewport",
}
_POINT = re.compile(r"\bgl_PointCoord\b")


def adapt_fragment(text: str) -> str:
    """Return a fragment shader's text as Vulkan is to get it; it may have a uniform HEIGHT more."""
    text = _POINT.sub("vec2(gl_PointCoord.x, 1.0 - gl_PointCoord.y)", text)
    return module_texts.assign_locations(module_texts.apply_coord_layout(text))


def compile_modules(sources: Sequence[Source]) -> Mapping[str, bytes]:
    """Return a program's modules by stage. Raises ShaderError: it is no GLSL; UnsupportedError: it
    is GLSL, but none that can be made into modules for Vulkan."""
    return module_texts.compile_to_modules(sources, "vulkan", "Vulkan").spirv["vulkan"]


def check_capabilities(device: Device, modules: Mapping[str, bytes]) -> None:
    """Raise UnsupportedError where a module takes a feature that the device or the lab lacks."""
    for stage, data in modules.items():
        if stage.startswith("tess_"):
            raise UnsupportedError(f"the {stage} stage: the lab tessellates on OpenGL only")
        for number in sorted(parse(data).capabilities - _ALWAYS):
            if number not in map(int, Capability):
                raise UnsupportedError(f"the {stage} stage takes SPIR-V capability {number}")
            feature = _FEATURES.get(number, f"shader{Capability(number).name}")
            if feature not in device.features:
                raise UnsupportedError(f"the {stage} stage takes {feature}: this device has none")


SAMPLED, UNIFORM, STORED = (
    constant(f"DESCRIPTOR_TYPE_{kind}")
    for kind in ("COMBINED_IMAGE_SAMPLER", "UNIFORM_BUFFER", "STORAGE_BUFFER")
)
"""Kinds of descriptors: a texture with its sampler, a uniform buffer, a storage buffer."""
DEFAULT_BLOCK = "gl_DefaultUniformBlock"
"""The block that uniforms outside of blocks become members of."""
_ALL_GRAPHICS = constant("SHADER_STAGE_ALL_GRAPHICS")
_MEMBER = re.compile(r"(\w+)(\[\d+\])?\.(\w+)(\[\d+\])?")


@dataclass(frozen=True)
class Binding:
    """A binding: its number, the kind and count of its descriptors, and the layout of a buffer."""

    number: int
    kind: int
    count: int = 1
    block: Block | None = None


def find_bindings(modules: Mapping[str, bytes]) -> dict[str, Binding]:
    """Return all bindings of a program by the names of blocks and of samplers. Raises
    UnsupportedError: a binding is in another set than the first, or is of another kind."""
    blocks = reflect(modules).blocks
    found: dict[str, Binding] = {}
    for data in modules.values():
        module = parse(data)
        for name, id_, storage in _find_bound_variables(module):
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


def _find_bound_variables(module: Module) -> Iterator[tuple[str, int, int]]:
    for storage in (StorageClass.UniformConstant, StorageClass.Uniform, StorageClass.StorageBuffer):
        for id_ in own_variables(module, storage):
            yield interface_name(module, id_), id_, storage
    for id_ in own_variables(module, StorageClass.PushConstant):
        raise UnsupportedError(f"{interface_name(module, id_)}: push constants have no values here")


def sampler_place(name: str, bindings: Mapping[str, Binding]) -> tuple[Binding, int] | None:
    """Return the binding and the element of it that a sampler is, by its name in GLSL for OpenGL;
    None if the modules leave it out. One out of a struct was lifted out of it."""
    lifted = _MEMBER.fullmatch(name)
    if lifted is not None:
        owner, first, member, second = (part or "" for part in lifted.groups())
        name = f"{owner}_{member}{first}{second}"
    base, _, index = name.partition("[")
    found = bindings.get(base)
    return None if found is None else (found, int(index.rstrip("]") or 0))


def new_set_layout(resources: Resources, bindings: Mapping[str, Binding]) -> Any:
    """Return the layout of the set that has all of a program's bindings."""
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


@dataclass(frozen=True)
class VertexLayout:
    """Where a pipeline reads vertices from; `topology` is the VkPrimitiveTopology.

    `streams` are for each attribute the number of its buffer, where it begins there and its stride,
    in bytes, and 1 if it goes on once an instance. Each has a separate binding, since attributes
    that follow one another in a buffer have strides of their own. `attributes` are of each vector
    that is read its location, its stream, its VkFormat and its offset from the stream's beginning.
    """

    streams: tuple[tuple[int, int, int, int], ...] = ()
    attributes: tuple[tuple[int, int, int, int], ...] = ()
    topology: int = PRIMITIVES.index("triangles")

    def input_state(self, structs: Structs) -> Any:
        return structs(
            "PipelineVertexInputStateCreateInfo",
            vertexBindingDescriptionCount=len(self.streams),
            pVertexBindingDescriptions=[
                (number, stride, divisor)
                for number, (_, _, stride, divisor) in enumerate(self.streams)
            ],
            vertexAttributeDescriptionCount=len(self.attributes),
            pVertexAttributeDescriptions=list(self.attributes),
        )


_DYNAMIC = [constant("DYNAMIC_STATE_VIEWPORT"), constant("DYNAMIC_STATE_SCISSOR")]


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
    """Modules on the device, and a pipeline for each layout that they are drawn with. Raises
    UnsupportedError: the modules take a feature that the device lacks."""

    def __init__(self, device: Device, modules: Mapping[str, bytes]) -> None:
        check_capabilities(device, modules)
        self._device = device
        self._resources = Resources(device)
        self.bindings = find_bindings(modules)
        self.attributes = _variables(modules["vertex"], StorageClass.Input)
        self.outputs = (
            _variables(modules["fragment"], StorageClass.Output) if "fragment" in modules else {}
        )
        self.set_layout = new_set_layout(self._resources, self.bindings)
        structs = Structs()
        whole = structs("PipelineLayoutCreateInfo", setLayoutCount=1, pSetLayouts=[self.set_layout])
        self.layout = self._resources.create("PipelineLayout", whole)
        self._stages: dict[str, Any] = {}
        for stage, code in modules.items():
            info = structs("ShaderModuleCreateInfo", codeSize=len(code), pCode=code)
            self._stages[stage] = self._resources.create("ShaderModule", info)
        self.pipeline = functools.cache(self._new_pipeline)

    def release(self) -> None:
        self._resources.close()

    def locations(self, names: Mapping[str, Any]) -> dict[int, str]:
        """Return where the program writes those of its outputs that have these names."""
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
            "PipelineRenderingCreateInfo",
            colorAttachmentCount=count,
            pColorAttachmentFormats=numbers,
            depthAttachmentFormat=depth,
            stencilAttachmentFormat=depth if stencil else 0,
        )
        stages = [
            structs(
                "PipelineShaderStageCreateInfo",
                stage=constant(f"SHADER_STAGE_{stage.upper()}_BIT"),
                module=made,
                pName="main",
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
            pRasterizationState=rasterisation_state(structs, device, layout.state),
            pMultisampleState=multisample_state(structs, device, layout.state, layout.samples),
            pDepthStencilState=depth_stencil_state(structs, layout.state),
            pColorBlendState=blend_state(structs, layout.state, colors, count),
            pDynamicState=structs(
                "PipelineDynamicStateCreateInfo", dynamicStateCount=len(_DYNAMIC),
                pDynamicStates=_DYNAMIC,
            ),
        )  # fmt: skip
        made = ffi.new("VkPipeline *")
        with phase("link"):
            result = lib.vkCreateGraphicsPipelines(device.handle, NULL, 1, info, NULL, made)
        check(result, "making a pipeline")
        return self._resources.own("Pipeline", made[0])


def _variables(data: bytes, storage: int) -> dict[str, Variable]:
    return {variable.name: variable for variable in stage_variables(parse(data), storage)}


class Linker(ProgramCache[Program]):
    device: Device

    def link(self, texts: Mapping[str, str], known: Sequence[Source] = ()) -> Program:
        """Return the program of these texts by stage, some of which may be those of `known`. Raises
        ShaderError, UnsupportedError: as `compile_modules` and `Program`."""

        def linked() -> Program:
            with phase("compile"):
                modules = compile_modules(module_texts.make_sources(texts, known))
            with phase("link"):
                return Program(self.device, modules)

        return self.get(tuple(sorted(texts.items())), linked)


# What Vulkan numbers in another order than `shaderlab.model.state`, where words stand in Vulkan's.
_FACES = (None, "front", "back", "front_and_back")
_WINDINGS = ("cw", "ccw")  # exchanged: see above
_LAST_VERTEX = constant("PROVOKING_VERTEX_MODE_LAST_VERTEX_EXT")
_BRESENHAM = constant("LINE_RASTERIZATION_MODE_BRESENHAM_EXT")


def pipeline_state(state: State) -> State:
    """Return what of a state a pipeline is made with; the rest is set when it draws."""
    return replace(
        state, cell=None, viewport=None, scissor=None, depth_range=(0.0, 1.0), point_size=None
    )


def viewport(state: State, size: tuple[int, int]) -> tuple[Rectangle, Rectangle]:
    """Return a draw's viewport and scissor in pixels of a target of `size`."""
    whole = (0, 0, *size)
    cell = None if state.cell is None else state.cell.rectangle(size)
    return cell or state.viewport or whole, _clip(cell or state.scissor or whole, size)


def _clip(box: Rectangle, size: tuple[int, int]) -> Rectangle:
    """Return the part of a rectangle that lies on the target: Vulkan takes no negative corners."""
    left, low = max(box[0], 0), max(box[1], 0)
    right, top = min(box[0] + box[2], size[0]), min(box[1] + box[3], size[1])
    return left, low, max(right - left, 0), max(top - low, 0)


def rasterisation_state(structs: Structs, device: Device, state: State) -> Any:
    """Return which faces are drawn, which vertex flat values come from, and how lines are drawn."""
    chain = structs(
        "PipelineRasterizationProvokingVertexStateCreateInfoEXT", provokingVertexMode=_LAST_VERTEX
    )
    if "bresenhamLines" in device.features and state.sample_shading is None:
        chain = structs(
            "PipelineRasterizationLineStateCreateInfoEXT",
            pNext=chain,
            lineRasterizationMode=_BRESENHAM,
        )
    factor, units = state.polygon_offset or (0.0, 0.0)
    return structs(
        "PipelineRasterizationStateCreateInfo",
        pNext=chain,
        cullMode=_FACES.index(state.cull),
        frontFace=_WINDINGS.index(state.front_face),
        lineWidth=1.0,
        depthBiasEnable=state.polygon_offset is not None,
        depthBiasSlopeFactor=factor,
        depthBiasConstantFactor=units,
    )


def multisample_state(structs: Structs, device: Device, state: State, samples: int) -> Any:
    """Return how samples are covered and shaded. Raises UnsupportedError."""
    if samples > 1 and not state.multisample:
        raise UnsupportedError("multisample=False: Vulkan covers the samples of a target always")
    if state.sample_shading is not None and "sampleRateShading" not in device.features:
        raise UnsupportedError("sample_shading: this device has no sampleRateShading")
    return structs(
        "PipelineMultisampleStateCreateInfo",
        rasterizationSamples=samples,
        sampleShadingEnable=state.sample_shading is not None,
        minSampleShading=state.sample_shading or 0.0,
        alphaToCoverageEnable=state.alpha_to_coverage and samples > 1,
    )


def depth_stencil_state(structs: Structs, state: State) -> Any:
    depth = state.depth or Depth()
    front = state.stencil or Stencil()
    return structs(
        "PipelineDepthStencilStateCreateInfo",
        depthTestEnable=state.depth is not None,
        depthWriteEnable=state.depth is not None and depth.write,
        depthCompareOp=COMPARISONS.index(depth.func),
        stencilTestEnable=state.stencil is not None,
        front=_stencil(structs, front),
        back=_stencil(structs, state.stencil_back or front),
    )


def _stencil(structs: Structs, stencil: Stencil) -> Any:
    number = STENCIL_OPERATIONS.index
    return structs(
        "StencilOpState",
        failOp=number(stencil.fail),
        depthFailOp=number(stencil.depth_fail),
        passOp=number(stencil.depth_pass),
        compareOp=COMPARISONS.index(stencil.func),
        compareMask=stencil.mask,
        writeMask=stencil.write_mask,
        reference=stencil.reference,
    )


def blend_state(structs: Structs, state: State, formats: Mapping[int, str], count: int) -> Any:
    """Return how colours are mixed into attachments, whose formats are by location."""
    blend = state.blend or Blend()
    mask = sum(1 << channel for channel, on in enumerate(state.color_mask) if on)
    words = {
        "srcColorBlendFactor": BLEND_FACTORS.index(blend.source),
        "dstColorBlendFactor": BLEND_FACTORS.index(blend.destination),
        "colorBlendOp": BLEND_EQUATIONS.index(blend.equation),
        "srcAlphaBlendFactor": BLEND_FACTORS.index(blend.source_alpha or blend.source),
        "dstAlphaBlendFactor": BLEND_FACTORS.index(blend.destination_alpha or blend.destination),
        "alphaBlendOp": BLEND_EQUATIONS.index(blend.equation_alpha or blend.equation),
    }
    each = [
        structs(
            "PipelineColorBlendAttachmentState", colorWriteMask=mask if place in formats else 0,
            blendEnable=state.blend is not None and place in formats
            and not COLOR[formats[place]].integer, **words,
        )
        for place in range(count)
    ]  # fmt: skip
    return structs(
        "PipelineColorBlendStateCreateInfo",
        attachmentCount=count,
        pAttachments=each,
        blendConstants=blend.constant,
    )
