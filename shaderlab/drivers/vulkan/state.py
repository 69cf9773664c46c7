"""A `State` in Vulkan's terms: what a pipeline is made with, and the rectangles of a draw.

Pictures lie in memory with their lowest row first, as in OpenGL, and nothing is flipped: Vulkan
takes that row for the upper one, so that what it calls clockwise is counter-clockwise to OpenGL.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from shaderlab.errors import UnsupportedError
from shaderlab.model.state import (
    BLEND_EQUATIONS,
    BLEND_FACTORS,
    COMPARISONS,
    Blend,
    Depth,
    Rectangle,
    State,
    Stencil,
)

from ..programs.textures import COLOR
from .api import Structs
from .device import Device

# What Vulkan numbers in another order than `shaderlab.model.state`, where words stand in Vulkan's.
_STENCIL = (
    "keep", "zero", "replace", "incr", "decr", "invert", "incr_wrap", "decr_wrap",
)  # fmt: skip
_FACES = (None, "front", "back", "front_and_back")
_WINDINGS = ("cw", "ccw")  # exchanged: see above
_LAST_VERTEX, _BRESENHAM = 1, 2


def in_pipeline(state: State) -> State:
    """What of a state a pipeline is made with; the rest is set when it draws."""
    return replace(
        state, cell=None, viewport=None, scissor=None, depth_range=(0.0, 1.0), point_size=None
    )


def viewport(state: State, size: tuple[int, int]) -> tuple[Rectangle, Rectangle]:
    """A draw's viewport and scissor in pixels of a target of `size`."""
    whole = (0, 0, *size)
    cell = None if state.cell is None else state.cell.rectangle(size)
    return cell or state.viewport or whole, _inside(cell or state.scissor or whole, size)


def _inside(box: Rectangle, size: tuple[int, int]) -> Rectangle:
    """The part of a rectangle that lies on the target: Vulkan takes no negative corners."""
    left, low = max(box[0], 0), max(box[1], 0)
    right, top = min(box[0] + box[2], size[0]), min(box[1] + box[3], size[1])
    return left, low, max(right - left, 0), max(top - low, 0)


def rasterisation(structs: Structs, device: Device, state: State) -> Any:
    """Which faces are drawn, which vertex flat values come from, and how lines are drawn."""
    chain = structs(
        "PipelineRasterizationProvokingVertexStateCreateInfoEXT", provokingVertexMode=_LAST_VERTEX
    )
    if "bresenhamLines" in device.features and state.sample_shading is None:
        chain = structs(
            "PipelineRasterizationLineStateCreateInfoEXT", pNext=chain,
            lineRasterizationMode=_BRESENHAM,
        )  # fmt: skip
    factor, units = state.polygon_offset or (0.0, 0.0)
    return structs(
        "PipelineRasterizationStateCreateInfo", pNext=chain, cullMode=_FACES.index(state.cull),
        frontFace=_WINDINGS.index(state.front_face), lineWidth=1.0,
        depthBiasEnable=state.polygon_offset is not None, depthBiasSlopeFactor=factor,
        depthBiasConstantFactor=units,
    )  # fmt: skip


def multisampling(structs: Structs, device: Device, state: State, samples: int) -> Any:
    """How samples are covered and shaded. Raises UnsupportedError."""
    if samples > 1 and not state.multisample:
        raise UnsupportedError("multisample=False: Vulkan covers the samples of a target always")
    if state.sample_shading is not None and "sampleRateShading" not in device.features:
        raise UnsupportedError("sample_shading: this device has no sampleRateShading")
    return structs(
        "PipelineMultisampleStateCreateInfo", rasterizationSamples=samples,
        sampleShadingEnable=state.sample_shading is not None,
        minSampleShading=state.sample_shading or 0.0,
        alphaToCoverageEnable=state.alpha_to_coverage and samples > 1,
    )  # fmt: skip


def depth_and_stencil(structs: Structs, state: State) -> Any:
    """The tests of depth and stencil."""
    depth = state.depth or Depth()
    front = state.stencil or Stencil()
    return structs(
        "PipelineDepthStencilStateCreateInfo", depthTestEnable=state.depth is not None,
        depthWriteEnable=state.depth is not None and depth.write,
        depthCompareOp=COMPARISONS.index(depth.func),
        stencilTestEnable=state.stencil is not None, front=_stencil(structs, front),
        back=_stencil(structs, state.stencil_back or front),
    )  # fmt: skip


def _stencil(structs: Structs, stencil: Stencil) -> Any:
    return structs(
        "StencilOpState", failOp=_STENCIL.index(stencil.fail),
        depthFailOp=_STENCIL.index(stencil.depth_fail), passOp=_STENCIL.index(stencil.depth_pass),
        compareOp=COMPARISONS.index(stencil.func), compareMask=stencil.mask,
        writeMask=stencil.write_mask, reference=stencil.reference,
    )  # fmt: skip


def blending(structs: Structs, state: State, formats: Mapping[int, str], count: int) -> Any:
    """How colours are mixed into attachments, whose formats are by the locations of outputs."""
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
        "PipelineColorBlendStateCreateInfo", attachmentCount=count, pAttachments=each,
        blendConstants=blend.constant,
    )  # fmt: skip
