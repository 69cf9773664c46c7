"""Running a scene's passes, and reading back what they drew."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any

from shaderlab.activity import doing
from shaderlab.errors import ShaderError, UnsupportedError
from shaderlab.frame import Array, Bindings, Image, PassDraw
from shaderlab.gl import bind, blocks, formats, state
from shaderlab.gl.bound import BoundTextures
from shaderlab.gl.capture_cache import CaptureCache
from shaderlab.gl.continuing import refuse_stale, taken_over
from shaderlab.gl.device import Device
from shaderlab.gl.prepare import PreparedDraw, output_types, pass_colors
from shaderlab.gl.programs import (
    Programs,
    output_locations,
    set_uniforms,
    uniform_locations,
)
from shaderlab.gl.stages import PREFIX
from shaderlab.gl.target import RenderTarget
from shaderlab.gl.uniform_buffers import UniformBuffers
from shaderlab.gl.vertices import PRIMITIVES, VertexArray, vertex_array
from shaderlab.model import Mesh, Pass, Scene, names_asked_for

Size = tuple[int, int]
Prepared = Mapping[str, tuple[PreparedDraw, ...]]


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """What one run of a scene's passes gave, as in `Frame`. `inactive` are uniforms without any
    effect."""

    images: Mapping[tuple[str, str], Image]
    bindings: Mapping[PassDraw, Bindings]
    gl_errors: Mapping[PassDraw, tuple[int, ...]]
    inactive: frozenset[str] = field(default_factory=frozenset)
    sample_positions: Mapping[str, Array] = field(default_factory=dict)


class Runner:
    """Runs scenes on one device; programs, and what was captured, are kept from one scene to the
    next."""

    def __init__(self, device: Device) -> None:
        self.device = device
        self.programs = Programs(device)
        self.captures = CaptureCache()
        device.context.gc_mode = "auto"

    @contextmanager
    def session(self, scene: Scene, prepared: Prepared, size: Size) -> Iterator[Session]:
        """A scene to be drawn and captured; its device memory is given back at the end.

        Args:
            scene: what to draw.
            prepared: each pass's draws, compiled.
            size: (width, height) for targets that do not say.
        """
        with ExitStack() as stack:
            yield Session(self, scene, prepared, size, stack)


class Session:
    """One scene on the device: its targets and textures, kept until the scene is through."""

    def __init__(
        self, runner: Runner, scene: Scene, prepared: Prepared, size: Size, stack: ExitStack
    ) -> None:
        self.runner = runner
        self.scene = scene
        self.prepared = prepared
        self.images: dict[tuple[str, str], Image] = {}
        self.bindings: dict[PassDraw, Bindings] = {}
        self.sample_positions: dict[str, Array] = {}
        self._size = size
        self._stack = stack
        self._targets: dict[str, RenderTarget] = {}
        self._textures = BoundTextures(runner.device, scene, self.images, self._targets, stack)
        self._blocks = UniformBuffers(runner.device, stack)
        self._arrays: dict[tuple[int, int], tuple[Any, Mesh | None, VertexArray]] = {}
        self._gl_errors: dict[PassDraw, tuple[int, ...]] = {}
        self._inactive: set[str] = set()
        self._asked = names_asked_for(scene)

    def run(self) -> Drawn:
        """Draw all passes in order.

        Raises:
            CaseError, ShaderError, UnsupportedError: see the modules that find them.
        """
        for description in self.scene.passes:
            self._run_pass(description)
        return Drawn(
            images=self.images,
            bindings=self.bindings,
            gl_errors=self._gl_errors,
            inactive=frozenset(self._inactive),
            sample_positions=self.sample_positions,
        )

    def extent(self, description: Pass) -> Size:
        """The size in pixels of a pass's target."""
        return description.target.size or self._size

    def _run_pass(self, description: Pass) -> None:
        """Draw one pass, then read its colour attachments, and depth or stencil if asked for."""
        prepared = self.prepared[description.name]
        colors = pass_colors(description, prepared)
        extent = self.extent(description)
        with doing("draw", f"making the target of pass {description.name!r}"):
            if description.onto:
                target = taken_over(self.scene, description, colors, self._targets)
            else:
                target = RenderTarget(self.runner.device, description.target, colors, extent)
                self._stack.callback(target.release)
                target.clear()
            self._targets[description.name] = target
            if description.target.samples:
                self.sample_positions[description.name] = target.sample_positions()
        for index, draw in enumerate(prepared):
            key = (description.name, index)
            refuse_stale(description, draw.draw, self._targets)
            with doing("draw", step(key, draw)):
                self.bindings[key] = self.bind(draw)
                self._draw(key, draw, target)
        with doing("draw"):
            target.resolve()
            # Drivers draw when they are made to: a program that hangs, hangs here.
            self.runner.device.context.finish()
        with doing("read", f"reading pass {description.name!r}"):
            self._read(description, target)

    def _read(self, description: Pass, target: RenderTarget) -> None:
        kinds = output_types(self.prepared[description.name])
        for name in target.colors:
            image = target.read(name)
            if description.target.colors is None:
                # There is no three-component attachment: drop what the shader never wrote.
                count = formats.components_of(kinds[name])
                image = Image(image.values[..., :count], image.format)
            self.images[description.name, name] = image
        for name in self._asked.get(description.name, ()):
            if name in target.attached and name not in target.colors:
                self.images[description.name, name] = target.read(name)

    def bind(self, draw: PreparedDraw) -> Bindings:
        """The draw's uniforms and textures as the shader will get them."""
        return bind.bind(draw.draw, draw.interface, self._textures.texels)

    def locations(self, key: PassDraw) -> dict[str, int]:
        """Where the driver put each uniform that a draw's program declares, samplers too."""
        draw = self.prepared[key[0]][key[1]]
        program = self.runner.programs.link({s.stage: s.text for s in draw.sources})
        declared = [n for n in draw.interface.uniforms if not n.startswith(PREFIX)]
        return uniform_locations(program, declared)

    def use(self, program: Any, draw: PreparedDraw, bindings: Bindings) -> None:
        """Set the program's uniforms and bind its textures."""
        ramps = {}
        if draw.draw.domain is not None:
            ramps = bind.ramp_uniforms(draw.draw, draw.interface.varyings)
        set_uniforms(program, ramps)
        members = blocks.variables(draw.interface)
        plain = {name: v for name, v in bindings.uniforms.items() if name not in members}
        self._inactive.update(set_uniforms(program, plain))
        self._inactive.update(self._blocks.bind(program, draw, bindings.uniforms))
        for unit, (name, source) in enumerate(draw.draw.textures.items()):
            variable = draw.interface.uniforms[name]
            if not self._textures.bind(program, unit, variable, source):
                self._inactive.add(name)

    def _draw(self, key: PassDraw, draw: PreparedDraw, target: RenderTarget) -> None:
        program, vao = self.ready(key, draw, target)
        drain_errors()
        submit(vao, program, draw)
        errors = drain_errors()
        if errors:
            self._gl_errors[key] = errors

    def ready(
        self, key: PassDraw, draw: PreparedDraw, target: RenderTarget
    ) -> tuple[Any, VertexArray]:
        """Bind and set everything for a draw, which `submit` then issues: its program and vertex
        array. Raises ShaderError if the driver refuses the program."""
        require_glsl(self.runner.device, draw)
        stages = {s.stage: s.text for s in draw.sources}
        try:
            program = self.runner.programs.link(stages)
        except ShaderError as error:
            raise ShaderError(
                error.message, file=draw.authored[-1].path, remedy=error.remedy
            ) from error
        self.use(program, draw, self.bindings[key])
        vao = self._vertex_array(program, draw.draw.mesh)
        target.bind(output_locations(program, target.colors))
        state.apply(draw.draw.state, target.size)
        return program, vao

    def _vertex_array(self, program: Any, mesh: Mesh | None) -> VertexArray:
        """The vertex array of a mesh for a program, made once and kept."""
        key = (id(program), id(mesh))
        if key not in self._arrays:
            made = vertex_array(self.runner.device, program, mesh)
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


def step(key: PassDraw, draw: PreparedDraw) -> str:
    """A draw in words: what is to blame if the driver goes down with it."""
    return f"draw {key[1]} of pass {key[0]!r}, program {' + '.join(draw.draw.shaders)}"


def submit(vao: VertexArray, program: Any, draw: PreparedDraw) -> None:
    """Issue the draw call itself."""
    from OpenGL import GL

    description = draw.draw
    last = draw.text("geometry") or draw.text("vertex") or ""
    if description.state.point_size is None:
        # A shader that gives points no size gets the default one, a pixel.
        (GL.glEnable if "gl_PointSize" in last else GL.glDisable)(GL.GL_PROGRAM_POINT_SIZE)
    mode = PRIMITIVES[description.mesh.primitive if description.mesh else "triangles"]
    if not description.vertex_array:
        GL.glUseProgram(program.glo)
        GL.glBindVertexArray(0)
        GL.glDrawArrays(mode, 0, vao.count)
        return
    vao.render(mode, instances=description.instances)


def drain_errors() -> tuple[int, ...]:
    """All GL errors raised since the last call, oldest first."""
    from OpenGL import GL

    errors: list[int] = []
    while (code := GL.glGetError()) != GL.GL_NO_ERROR and len(errors) < 16:
        errors.append(int(code))
    return tuple(errors)
