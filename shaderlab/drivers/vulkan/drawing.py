"""Drawing a scene's passes, and reading back what they drew."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, Bindings
from shaderlab.model.scene import Target
from shaderlab.model.state import State

from .. import Size
from ..programs import blocks
from ..programs.module_texts import HEIGHT, as_drawn
from ..programs.prepare import PreparedDraw, Programs
from ..redrawing import RedrawingSession
from . import state as fixed
from .bound_textures import BoundTextures
from .commands import Commands, recording
from .descriptors import BoundImage, block_buffers, new_set, sampler_place
from .device import Device
from .linking import Linker
from .memory import Buffer, Resources
from .modules import for_vulkan
from .program import Layout, Program
from .ready import Ready
from .target import RenderTarget
from .vertices import layout_of, upload


class Drawing(RedrawingSession[RenderTarget, Linker]):
    """One scene on the device: its targets and textures, kept until the session ends."""

    device: Device
    _textures: BoundTextures

    def __init__(
        self, linker: Linker, scene: Scene, programs: Programs, size: Size, stack: ExitStack
    ) -> None:
        super().__init__(linker, scene, programs, size, stack)
        self.subpixel_step = 2.0**-self.device.limits.subPixelPrecisionBits
        self._resources = stack.enter_context(Resources(self.device))
        self._textures = BoundTextures(
            self.folder, self.images, self.targets, self._resources, linker
        )
        self._shared = blocks.SharedLayouts()

    def new_target(self, target: Target, colors: Mapping[str, str], size: Size) -> RenderTarget:
        return RenderTarget(self.device, target, colors, size)

    def render(
        self,
        draw: PreparedDraw,
        bindings: Bindings,
        target: RenderTarget,
        *,
        texts: Mapping[str, str] | None = None,
        fixed_state: State | None = None,
        around: Callable[[Commands, Callable[[], None]], None] | None = None,
    ) -> None:
        """As `RedrawingSession.render`; `around` records the draw by calling what it is given, with
        commands of its own before and after."""
        with Resources(self.device) as own:
            ready = self.ready(own, draw, bindings, target, texts=texts, fixed_state=fixed_state)
            with recording(self.device) as commands:

                def drawn() -> None:
                    target.begin(commands, ready.locations, srgb=ready.state.srgb)
                    ready.record(commands, target.size)
                    target.end(commands)

                if around is None:
                    drawn()
                else:
                    around(commands, drawn)

    def ready(
        self,
        own: Resources,
        draw: PreparedDraw,
        bindings: Bindings,
        target: RenderTarget,
        *,
        texts: Mapping[str, str] | None = None,
        fixed_state: State | None = None,
        stored: Mapping[str, Buffer] | None = None,
    ) -> Ready:
        """All that a draw takes, on the device; `own` are what is released after it.

        Args:
            texts, fixed_state: as in `render`.
            stored: storage buffers by the names of their blocks.
        """
        description, state = draw.draw, fixed_state or draw.draw.state
        if not description.vertex_array:
            raise UnsupportedError("vertex_array=False: Vulkan has no vertex arrays to leave out")
        program = self.program(draw, texts or draw.texts)
        locations = program.locations(target.colors)
        layout = Layout(
            layout_of(description.mesh, program.attributes),
            tuple(target.formats(locations, srgb=state.srgb).items()),
            target.depth, target.samples, fixed.in_pipeline(state),
        )  # fmt: skip
        values = {**bindings.uniforms, HEIGHT: np.array([target.size[1]], np.float32)}
        return Ready(
            program, layout, locations, state,
            upload(own, description.mesh, program.attributes), description.instances,
            self._descriptors(own, program, draw, values, stored or {}),
        )  # fmt: skip

    def program(self, draw: PreparedDraw, texts: Mapping[str, str]) -> Program:
        """The program of a draw, its stages having these texts."""
        own = dict(texts)
        if "fragment" in own:
            own["fragment"] = for_vulkan(own["fragment"])
        own = as_drawn(draw.draw, own)
        return self.linker.link(own, draw.sources)

    def _descriptors(
        self,
        own: Resources,
        program: Program,
        draw: PreparedDraw,
        values: dict[str, Array],
        stored: Mapping[str, Buffer],
    ) -> object:
        values |= draw.ramps
        for name, block in blocks.uniform_blocks(draw.interface).items():
            self._shared.check(draw.draw.blocks[name], block)
        buffers = block_buffers(own, program.bindings, values, stored)
        images: dict[str, BoundImage] = {}
        for name, source in draw.draw.textures.items():
            if sampler_place(name, program.bindings) is None:
                self._inactive.add(name)
                continue
            images[name] = self._textures.bound(draw.interface.uniforms[name], source)
        return new_set(own, program.set_layout, program.bindings, buffers, images)
