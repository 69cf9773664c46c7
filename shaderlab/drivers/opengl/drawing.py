"""Drawing a scene's passes, and reading back what they drew."""

from __future__ import annotations

from collections.abc import Container, Mapping
from contextlib import ExitStack, nullcontext
from dataclasses import replace
from typing import Any

import numpy as np

from shaderlab.errors import ShaderError, UnsupportedError
from shaderlab.model.activity import doing
from shaderlab.model.case import Scene
from shaderlab.model.frame import Bindings, PassDraw
from shaderlab.model.mesh import Mesh
from shaderlab.model.scene import Target
from shaderlab.model.state import State

from .. import Drawn, Size
from ..programs import blocks, storage
from ..programs.prepare import PreparedDraw, Programs, step
from ..programs.stages import NUMBER
from ..redrawing import RedrawingSession
from . import state
from .bound_textures import BoundTextures
from .device import Device
from .dispatch import dispatch
from .linking import Linker, output_locations, set_uniforms
from .probes import require_inputs
from .pyopengl import GL, named
from .target import RenderTarget
from .uniform_buffers import UniformBuffers
from .vertices import VertexArray, vertex_array


class Drawing(RedrawingSession[RenderTarget, Linker]):
    """One scene on the device: its targets and textures, kept until the session ends."""

    device: Device
    _textures: BoundTextures

    def __init__(
        self, linker: Linker, scene: Scene, programs: Programs, size: Size, stack: ExitStack
    ) -> None:
        super().__init__(linker, scene, programs, size, stack)
        self._textures = BoundTextures(self.folder, self.images, self.targets, self.device, stack)
        self._blocks = UniformBuffers(self.device, stack)
        self._arrays: dict[tuple[int, int], tuple[Any, Mesh | None, VertexArray]] = {}

    def draw(self, only: Container[str] | None = None) -> Drawn:
        recorder = self.device.recorder
        with nullcontext() if recorder is None else recorder.recording():
            return super().draw(only)

    def new_target(self, target: Target, colors: Mapping[str, str], size: Size) -> RenderTarget:
        return RenderTarget(self.device, target, colors, size)

    @property
    def uploads_images(self) -> bool:
        return True

    @property
    def keeps_targets(self) -> bool:
        return self.device.recorder is not None  # each object keeps a number of its own

    def at(self, pass_name: str, draw: int | None = None) -> None:
        self.device.at(pass_name, draw)

    def reading(self) -> None:
        self.device.reading()

    def finish(self) -> None:
        self.device.context.finish()

    def compute(self, key: PassDraw, draw: PreparedDraw) -> None:
        storage.require_supported(draw.draw, draw.interface)
        with doing("draw", step(key, draw)):
            given = self.bind(draw)
            found = storage.bound(draw.draw, draw.interface, given, self.folder, self.images)
            self.bindings[key] = found
            program = self._linked(draw, draw.texts)
            self.use(program, draw, found)
            drain_errors()
            left = dispatch(self.device, program, draw, found)
            errors = drain_errors()
        self.images |= {(key[0], name): image for name, image in left.items()}
        if errors:
            self._gl_errors[key] = errors

    def use(
        self,
        program: Any,
        draw: PreparedDraw,
        bindings: Bindings,
        *,
        only_active: bool = False,
    ) -> None:
        """Set the program's uniforms and bind its textures; `only_active`: uniforms that it does
        not know are left out."""
        set_uniforms(program, draw.ramps)
        members = blocks.variables(draw.interface)
        plain = {
            name: value
            for name, value in bindings.uniforms.items()
            if name not in members and not (only_active and program.get(name, None) is None)
        }
        self._inactive.update(set_uniforms(program, plain))
        self._inactive.update(self._blocks.bind(program, draw, bindings.uniforms))
        for unit, (name, source) in enumerate(draw.draw.textures.items()):
            variable = draw.interface.uniforms[name]
            if not self._textures.bind(program, unit, variable, source):
                self._inactive.add(name)

    def issue(self, key: PassDraw, draw: PreparedDraw, target: RenderTarget) -> None:
        program, vao = self.ready(draw, self.bindings[key], target)
        drain_errors()
        submit(vao, program, draw)
        errors = drain_errors()
        if errors:
            self._gl_errors[key] = errors

    def render(
        self,
        draw: PreparedDraw,
        bindings: Bindings,
        target: RenderTarget,
        *,
        texts: Mapping[str, str] | None = None,
        fixed_state: State | None = None,
    ) -> None:
        program, vao = self.ready(draw, bindings, target, texts=texts, fixed_state=fixed_state)
        submit(vao, program, draw)
        drain_errors()

    def numbered(self, text: str, bindings: Bindings, index: int) -> tuple[str, Bindings]:
        if self.device.takes_spirv:
            return super().numbered(text, bindings, index)
        # Draws of one text have one program.
        number = np.array(index + 1, np.float32)
        return text, replace(bindings, uniforms={**bindings.uniforms, NUMBER: number})

    def ready(
        self,
        draw: PreparedDraw,
        bindings: Bindings,
        target: RenderTarget,
        *,
        texts: Mapping[str, str] | None = None,
        fixed_state: State | None = None,
    ) -> tuple[Any, VertexArray]:
        """Bind and set everything for a draw, which `submit` then issues: its program and vertex
        array. Arguments and errors as of `render`."""
        require_inputs(self.device, draw)
        program = self._linked(draw, texts or draw.texts)
        self.use(program, draw, bindings, only_active=texts is not None)
        vao = self._vertex_array(program, draw.draw.mesh)
        target.bind(output_locations(program, target.colors))
        state.apply(fixed_state or draw.draw.state, target.size, self.device.version)
        return program, vao

    def _linked(self, draw: PreparedDraw, texts: Mapping[str, str]) -> Any:
        """A draw's program, its stages having these texts."""
        require_glsl(self.device, draw)
        try:
            return self.linker.link(texts)
        except ShaderError as error:
            raise ShaderError(
                error.message, file=draw.authored[-1].path, remedy=error.remedy
            ) from error

    def _vertex_array(self, program: Any, mesh: Mesh | None) -> VertexArray:
        """The vertex array of a mesh for a program, made once and kept."""
        key = (id(program), id(mesh))
        if key not in self._arrays:
            made = vertex_array(self.device, program, mesh)
            # Program and mesh are kept with it, so that nothing else gets their identity.
            self._arrays[key] = (program, mesh, made)
        return self._arrays[key][2]


def require_glsl(device: Device, draw: PreparedDraw) -> None:
    """Raise UnsupportedError for a shader of a newer GLSL than the driver takes."""
    for source in draw.sources:
        number, profile = source.version
        if profile != "es" and number > device.glsl:
            raise UnsupportedError(
                f"#version {number}: this driver takes GLSL up to {device.glsl}", file=source.path
            )


def submit(vao: VertexArray, program: Any, draw: PreparedDraw) -> None:
    """Issue the draw call itself."""
    description = draw.draw
    if description.state.point_size is None:
        # A shader that gives points no size gets the default one, a pixel.
        (GL.glEnable if "gl_PointSize" in draw.last_text else GL.glDisable)(
            GL.GL_PROGRAM_POINT_SIZE
        )
    mode = named(description.mesh.primitive if description.mesh else "triangles")
    if description.mesh is not None and mode == GL.GL_PATCHES:
        GL.glPatchParameteri(GL.GL_PATCH_VERTICES, description.mesh.patch_vertices)
    if not description.vertex_array:
        GL.glUseProgram(program.glo)
        GL.glBindVertexArray(0)
        GL.glDrawArrays(mode, 0, vao.count)
        return
    vao.render(mode, instances=description.instances)


def drain_errors() -> tuple[int, ...]:
    """All GL errors raised since the last call, oldest first."""
    errors: list[int] = []
    while (code := GL.glGetError()) != GL.GL_NO_ERROR and len(errors) < 16:
        errors.append(int(code))
    return tuple(errors)
