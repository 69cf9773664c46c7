"""Drawing a scene's passes, and reading back what they drew."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.case import Scene
from shaderlab.model.frame import Bindings, PassDraw
from shaderlab.model.scene import Target
from shaderlab.model.state import State

from .. import Size
from ..programs import blocks
from ..programs.module_texts import HEIGHT, as_drawn
from ..programs.prepare import PreparedDraw, Programs
from ..redrawing import RedrawingSession
from . import state as fixed
from .bound_textures import BoundTextures
from .calls import Objects
from .device import Device
from .linking import Linker, Program
from .target import RenderTarget
from .vertices import VertexArray, vertex_array


class Drawing(RedrawingSession[RenderTarget, Linker]):
    """One scene on the device: its targets and textures, kept until the session ends."""

    device: Device
    _textures: BoundTextures

    def __init__(
        self, linker: Linker, scene: Scene, programs: Programs, size: Size, stack: ExitStack
    ) -> None:
        super().__init__(linker, scene, programs, size, stack)
        self.subpixel_step = 2.0 ** -self.device.gl.about["subpixel"]
        own = stack.enter_context(Objects(self.device.gl))
        self._textures = BoundTextures(self.folder, self.images, self.targets, self.device, own)
        self._shared = blocks.SharedLayouts()

    def new_target(self, target: Target, colors: Mapping[str, str], size: Size) -> RenderTarget:
        return RenderTarget(self.device, target, colors, size)

    def issue(self, key: PassDraw, draw: PreparedDraw, target: RenderTarget) -> None:
        super().issue(key, draw, target)

        def note(errors: list[int]) -> None:
            if errors:
                self._gl_errors[key] = tuple(errors)

        self.device.gl.ask_later(note, "errors")

    def finish(self) -> None:
        self.device.gl.ask("finish")

    def render(
        self,
        draw: PreparedDraw,
        bindings: Bindings,
        target: RenderTarget,
        *,
        texts: Mapping[str, str] | None = None,
        fixed_state: State | None = None,
    ) -> None:
        state = fixed_state or draw.draw.state
        encodes = "srgb8_alpha8" in target.colors.values()
        fixed.check(state, samples=target.samples, encodes=encodes)
        program = self.linker.link(as_drawn(draw.draw, texts or draw.texts), draw.sources)

        def draw_to(vertices: VertexArray) -> None:
            target.bind(program.outputs(target.colors))
            fixed.apply(self.device.gl, state, target.size)
            vertices.draw(self.device.gl, draw.draw.instances)

        values = {HEIGHT: np.array([target.size[1]], np.float32)}
        self.use(program, draw, bindings, values, draw_to)

    def use(
        self,
        program: Program,
        draw: PreparedDraw,
        bindings: Bindings,
        values: Mapping[str, np.ndarray],
        then: Callable[[VertexArray], None],
    ) -> None:
        """Set a program's uniforms and bind its textures and its mesh, and go on with the vertex
        array.

        Args:
            program: of the draw, whatever its texts.
            draw: what to draw.
            bindings: its uniforms and textures.
            values: further uniforms, by name.
            then: what is done with it.

        Raises:
            UnsupportedError: WebGL2 has no such thing; the message names it.
        """
        if not draw.draw.vertex_array:
            raise UnsupportedError("vertex_array=False: WebGL2 always has a vertex array")
        gl = self.device.gl
        with Objects(gl) as own:
            gl.useProgram(program.handle)
            self._uniforms(program, draw, {**bindings.uniforms, **values})
            self._blocks(own, program, draw, bindings)
            unit = 0
            for name, source in draw.draw.textures.items():
                if name not in program.locations:
                    self._inactive.add(name)
                    continue
                self._textures.bind(unit, draw.interface.uniforms[name], source)
                gl.uniform1i(program.locations[name], unit)
                unit += 1
            then(vertex_array(own, draw.draw.mesh, program.interface.attributes))
            gl.bindVertexArray(None)

    def _uniforms(
        self, program: Program, draw: PreparedDraw, values: Mapping[str, np.ndarray]
    ) -> None:
        members = blocks.variables(draw.interface)
        for name, value in {**values, **draw.ramps}.items():
            if name not in members and not program.set(name, value):
                self._inactive.add(name)
        self._inactive.discard(HEIGHT)

    def _blocks(
        self, own: Objects, program: Program, draw: PreparedDraw, bindings: Bindings
    ) -> None:
        """A buffer for each uniform block."""
        gl = self.device.gl
        for point, (name, block) in enumerate(blocks.uniform_blocks(draw.interface).items()):
            self._shared.check(draw.draw.blocks[name], block)
            if name not in program.blocks:
                self._inactive.add(name)
                continue
            buffer = own.new("Buffer")
            gl.bindBuffer(gl.UNIFORM_BUFFER, buffer)
            gl.bufferData(
                gl.UNIFORM_BUFFER, blocks.packed(block, bindings.uniforms), gl.STATIC_DRAW
            )
            gl.uniformBlockBinding(program.handle, program.blocks[name], point)
            gl.bindBufferBase(gl.UNIFORM_BUFFER, point, buffer)
