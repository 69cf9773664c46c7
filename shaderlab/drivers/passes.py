"""Sessions that draw a scene pass by pass, the same way for every graphics API: a driver says how
a target is made and how a draw is issued."""

import time
from abc import abstractmethod
from collections.abc import Container, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.case import Scene
from shaderlab.model.frame import (
    Array,
    Bindings,
    Fragments,
    Image,
    PassDraw,
    Samples,
    Timing,
    leading,
)
from shaderlab.model.phases import phase
from shaderlab.model.scene import Draw, Pass, Target

from . import Answers, Backend, Drawn, Session, Size
from .programs import bind, captures, prepare
from .programs.captures import Captured, Parts, Probed, Texts
from .programs.prepare import PreparedDraw, Programs
from .programs.stages import NUMBER
from .programs.textures import components_of
from .resources import Attachments, ProgramCache, SceneTextures

TargetKind = TypeVar("TargetKind", bound=Attachments)
LinkerKind = TypeVar("LinkerKind", bound=ProgramCache[Any])


class PassSession(Session, Generic[TargetKind, LinkerKind]):
    """A session that draws its scene pass by pass, targets that do not say in `size` (width,
    height); `linker` makes the programs, `stack` releases device memory in the end."""

    shares_captures = False
    """Whether draws of a pass are captured together, told apart by a uniform."""

    target_class: type[TargetKind]
    _textures: SceneTextures[Any]  # what the scene's samplers read

    def __init__(
        self, linker: LinkerKind, scene: Scene, programs: Programs, size: Size, stack: ExitStack
    ) -> None:
        super().__init__(scene, programs)
        self.linker = linker
        self.device = linker.device
        self.size = size
        self.stack = stack
        self.folder = Path(scene.case.file).parent
        self.bindings: dict[PassDraw, Bindings] = {}
        self.images: dict[tuple[str, str], Image] = {}
        self.targets: dict[str, TargetKind] = {}
        self._named = scene.named_outputs()
        self._gl_errors: dict[PassDraw, tuple[int, ...]] = {}
        self._inactive: set[str] = set()
        self._sample_positions: dict[str, Array] = {}
        self._plain: dict[PassDraw, Draw] = {}
        self._together: dict[str, list[captures.SharedCapture]] = {}
        self._shared = bind.SharedLayouts()
        self.start()

    # What a driver does by its API.

    @abstractmethod
    def start(self) -> None:
        """Make what the scene keeps on the device: `_textures`, and what else the driver has."""

    @abstractmethod
    def render(self, draw: PreparedDraw, bindings: Bindings, target: TargetKind) -> None:
        """Draw into a target with these uniforms and textures, and wait until it is drawn. Raises
        UnsupportedError: the API, or the device, has no such thing."""

    @abstractmethod
    def capture_outputs(
        self, draw: PreparedDraw, texts: Texts, parts: Parts, bindings: Bindings, count: int | None
    ) -> Captured:
        """As `shaderlab.drivers.programs.captures.CaptureOutputs`."""

    def issue(self, key: PassDraw, draw: PreparedDraw, target: TargetKind) -> None:
        """Draw one of the scene's draws, whose bindings are made, and note the errors it raises."""
        self.render(draw, self.bindings[key], target)

    def compute(self, key: PassDraw, draw: PreparedDraw) -> None:
        """Run a compute shader, and take what it leaves in its buffers for images of its pass."""
        raise UnsupportedError("compute passes: this driver has none")

    def at(self, pass_name: str | None, draw: int | None = None) -> None:
        """Note the pass and the draw that calls are made for from now on; None for the lab's own,
        by which it reads what was drawn."""

    def finish(self) -> None:
        """Wait until all is drawn."""

    # Drawing.

    def draw(self, only: Container[str] | None = None) -> Drawn:
        for description in self.scene.passes:
            if only is None or description.name in only:
                self.run_pass(description)
        return Drawn(
            images=self.images,
            bindings=self.bindings,
            gl_errors=self._gl_errors,
            inactive=frozenset(self._inactive),
            sample_positions=self._sample_positions,
        )

    def run_pass(self, description: Pass) -> None:
        """Draw one pass, then read its colour attachments, and depth or stencil if asked for."""
        draws = self.programs[description.name]
        if description.computes:
            self.at(description.name, 0)
            prepare.check_reads(self.scene, description, draws[0].draw, self.targets)
            self.compute((description.name, 0), draws[0])
            return
        with phase("draw", f"making the target of pass {description.name!r}"):
            target = self._target(description)
        for index, draw in enumerate(draws):
            key = (description.name, index)
            self.at(*key)
            prepare.check_reads(self.scene, description, draw.draw, self.targets)
            with phase("draw", prepare.describe_draw(key, draw)):
                self.bindings[key] = self.bind(draw)
                self.issue(key, draw, target)
        with phase("draw"):
            self.at(description.name)
            target.resolve()
            # Drivers draw when they are made to: a program that hangs, hangs here.
            self.finish()
        with phase("read", f"reading pass {description.name!r}"):
            self.at(None)
            self._read(description, target)

    def bind(self, draw: PreparedDraw) -> Bindings:
        """Return the draw's uniforms and textures as the shader will get them."""
        return bind.bind(draw.draw, draw.interface, self._textures.texels)

    def extent(self, description: Pass) -> Size:
        return description.target.size or self.size

    def _target(self, description: Pass) -> TargetKind:
        """Make a target for a pass, cleared, or find the one that it goes on in."""
        colors = dict(prepare.pass_colors(description, self.programs[description.name]))
        self.at(description.name)
        if description.onto:
            earlier = {name: target.colors for name, target in self.targets.items()}
            prepare.check_continues(self.scene, description, colors, earlier)
            target = self.targets[description.onto]
        else:
            target = self.new_target(description.target, colors, self.extent(description))
            self.stack.callback(target.release)
            target.clear()
        self.targets[description.name] = target
        if description.target.samples:
            self.at(None)
            self._sample_positions[description.name] = target.sample_positions()
        return target

    def _read(self, description: Pass, target: TargetKind) -> None:
        kinds = prepare.output_types(self.programs[description.name])
        for name in target.colors:
            image = target.read(name)
            if description.target.colors is None:
                # There is no three-component attachment: drop what the shader never wrote.
                count = components_of(kinds[name])
                image = Image(leading(image.values, count), image.format)
            self.images[description.name, name] = image
        for name in self._named.get(description.name, ()):
            if name in target.attached and name not in target.colors:
                self.images[description.name, name] = target.read(name)

    # Drawing once more.

    def new_target(self, target: Target, colors: Mapping[str, str], size: Size) -> TargetKind:
        return self.target_class(self.device, target, colors, size)

    def fresh_target(self, pass_name: str) -> TargetKind:
        """Make another target like that of a pass. Raises UnsupportedError: it draws nothing."""
        description = self.scene.find_pass(pass_name)
        if description.computes:
            raise UnsupportedError(f"drawing pass {pass_name!r} once more: it is a dispatch")
        colors = prepare.pass_colors(description, self.programs[pass_name])
        return self.new_target(description.target, colors, self.extent(description))

    def redraw_pass(self, changed: Pass, output: str, largest: int) -> Array:
        width, height = self.extent(changed)
        share = min(1.0, largest / max(width, height))
        if not any(draw.state.in_pixels for draw in changed.draws):
            width, height = round(width * share) or 1, round(height * share) or 1
        name, errors = changed.name, self._gl_errors
        self._gl_errors = {}  # they were raised before, in the pass itself
        try:
            self.at(None)
            colors = prepare.pass_colors(changed, self.programs[name])
            with self.new_target(changed.target, colors, (width, height)) as one:
                for index, draw in enumerate(self.programs[name]):
                    state = changed.draws[index].state
                    other = replace(draw, draw=replace(draw.draw, state=state))
                    self.issue((name, index), other, one)
                return one.read(output).values
        finally:
            self._gl_errors = errors

    def redraw_with_text(
        self, key: PassDraw, text: str, outputs: Mapping[str, str]
    ) -> Mapping[str, Array]:
        draws, redraw = self._redraw_of(key[0])
        return captures.redraw_with_text(draws, key[1], redraw, text, outputs)

    def redraw_with_texts(
        self, description: Pass, target: Target, texts: Sequence[str]
    ) -> Mapping[str, Array]:
        """Draw a pass's first draws once more, each with another of these fragment texts, without
        what changes the values that it writes: blending and masks. Returns the attachments."""
        name, colors = description.name, dict(target.colors or {})
        with self.new_target(target, colors, self.extent(description)) as made:
            for index, (draw, text) in enumerate(zip(self.programs[name], texts, strict=False)):
                key, stages = (name, index), {**draw.texts, "fragment": text}
                if key not in self._plain:
                    state = replace(draw.draw.state, blend=None, srgb=False, color_mask=(True,) * 4)
                    self._plain[key] = replace(draw.draw, state=state)
                bindings = self.bindings[key]
                if NUMBER in text:
                    number = {NUMBER: np.array([index + 1.0], np.float32)}
                    bindings = replace(bindings, uniforms={**bindings.uniforms, **number})
                self.render(replace(draw, draw=self._plain[key], rewritten=stages), bindings, made)
            return {name: made.read(name).values for name in colors}

    # Captures and probes.

    def capture_fragments(self, key: PassDraw) -> Fragments:
        draws, redraw = self._redraw_of(key[0])
        known = self._together.get(key[0], [])
        shared = next((each for each in known if key[1] in each.pieces), None)
        if shared is None and self.shares_captures:
            shared = captures.capture_together(draws, key[1], redraw)
            # Only those of one pass are kept: they are as large as pictures.
            self._together = {key[0]: known if shared is None else [*known, shared]}
        return captures.capture_fragments(draws, key[1], redraw, shared)

    def _redraw_of(self, name: str) -> tuple[Sequence[PreparedDraw], captures.Redraw]:
        """Return a pass's draws, and what redraws them without blending into other attachments."""
        description = self.scene.find_pass(name)

        def redraw(texts: Sequence[str], colors: Mapping[str, str]) -> Mapping[str, Array]:
            plain = replace(description.target, colors=colors, clear=(0.0,) * 4, samples=0)
            return self.redraw_with_texts(description, plain, texts)

        return self.programs[name], redraw

    def capture_vertices(self, key: PassDraw) -> Samples:
        draw = self.programs[key[0]][key[1]]
        return captures.capture_vertices(draw, self.bindings[key], self.capture_outputs)

    def probe(
        self, key: PassDraw, stage: Probed, runs: Sequence[Bindings], inputs: Mapping[str, Array]
    ) -> list[Samples]:
        draw = self.programs[key[0]][key[1]]
        if stage == "vertex":
            return [
                captures.probe_vertices(draw, each, inputs, self.capture_outputs) for each in runs
            ]
        return captures.probe_fragments(draw, runs, inputs, self._draw_points)

    def _draw_points(
        self,
        points: PreparedDraw,
        bindings: Bindings,
        target: Target,
        colors: Mapping[str, str],
        size: Size,
    ) -> Mapping[str, Array]:
        with self.new_target(target, colors, size) as made:
            self.render(points, bindings, made)
            names = (*colors, "stencil") if target.depth else colors
            return {name: made.read(name).values for name in names}

    # Queries.

    def _time(self, pass_name: str, repeats: int) -> Timing:
        """Time how long a pass takes to draw, from its first draw until the driver has finished,
        Python included. The first time through, when drivers compile, does not count."""
        draws = self.programs[pass_name]
        seconds = []
        with self.fresh_target(pass_name) as target:
            for turn in range(repeats + 1):
                target.clear()
                self.finish()
                start = time.perf_counter()
                for index, draw in enumerate(draws):
                    self.render(draw, self.bindings[pass_name, index], target)
                self.finish()
                if turn:
                    seconds.append(time.perf_counter() - start)
        vertices = 0
        for draw in draws:
            mesh = draw.draw.mesh
            drawn = 3 if mesh is None else mesh.vertices
            drawn = drawn if mesh is None or mesh.indices is None else len(mesh.indices)
            vertices += drawn * draw.draw.instances
        return Timing(draw_calls=len(draws), vertices=vertices, seconds=tuple(seconds))

    def _attachment(self, pass_name: str, name: str) -> Image:
        if (pass_name, name) in self.images:
            return self.images[pass_name, name]
        self.at(None)
        return self.targets[pass_name].read(name)

    def find_errors(self, key: PassDraw) -> Sequence[int]:
        """Return the errors of OpenGL that a draw raised."""
        return self._gl_errors.get(key, ())

    answers: ClassVar[Answers] = {"attachment": _attachment, "time": _time}


class DeviceBackend(Backend):
    """Draws scenes on one device; keeps programs from one to the next.

    A driver names the classes of its linker and of its sessions.
    """

    linker_class: type[ProgramCache[Any]]
    session_class: type[PassSession[Any, Any]]

    def __init__(self, device: Any) -> None:
        self.device = device
        self.info = device.info
        self.linker = self.linker_class(device)

    @contextmanager
    def session(
        self, scene: Scene, programs: Programs, size: Size
    ) -> Iterator[PassSession[Any, Any]]:
        with self.in_use(), ExitStack() as stack:
            yield self.session_class(self.linker, scene, programs, size, stack)

    def in_use(self) -> AbstractContextManager[object]:
        """Let this thread use the device for a while."""
        return nullcontext()
