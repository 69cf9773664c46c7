"""Programs on the device: modules, what they are bound to, and the pipelines made of them."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from shaderlab.compiler.interface import Variable
from shaderlab.compiler.module import Storage, parse
from shaderlab.compiler.variables import stage_variables
from shaderlab.model.activity import doing
from shaderlab.model.state import State

from . import state as fixed
from .api import NULL, Structs, check, ffi, lib
from .descriptors import bindings_of, new_set_layout
from .device import Device
from .formats import STENCIL_ASPECT, aspects, vulkan_format
from .memory import Resources
from .modules import check_capabilities
from .vertices import VertexLayout

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
        self.attributes = _variables(modules["vertex"], Storage.INPUT)
        self.outputs = (
            _variables(modules["fragment"], Storage.OUTPUT) if "fragment" in modules else {}
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
