"""What a pass draws into, the same for every graphics API."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Container, Hashable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Generic, Literal, Protocol, Self, TypeVar

from shaderlab.errors import ShaderError, UnsupportedError
from shaderlab.model.activity import doing
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, Bindings, Fragments, Image, PassDraw, Samples, leading
from shaderlab.model.scene import Pass, Target
from shaderlab.model.state import State

from . import Drawn, Session, Size
from .programs import bind, vertex_capture
from .programs.fragment_capture import FragmentProbe, PassCapture, fragment_probe, numbered, refused
from .programs.prepare import (
    PreparedDraw,
    Programs,
    check_continues,
    check_reads,
    output_types,
    pass_colors,
    step,
)
from .programs.stages import Piece
from .programs.textures import DEPTH, components_of
from .protocol import Answers
from .scene_textures import SceneTextures


class Attachments(ABC):
    """The attachments of one pass at one size, on a device. As a context manager they are cleared
    first and released in the end.

    Args:
        target: sizes, clear values, depth format, samples.
        colors: format by output name, in the order of the outputs' locations.
        size: (width, height) in pixels.

    Attributes:
        depth: the format of depth and stencil, "" for none.

    Raises:
        UnsupportedError: the device can't make such a target; the message says which.
    """

    def __init__(self, target: Target, colors: Mapping[str, str], size: tuple[int, int]) -> None:
        self.size = size
        self.colors = dict(colors)
        self.depth = target.depth or ""
        self._target = target

    def __enter__(self) -> Self:
        self.clear()
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    @property
    def attached(self) -> tuple[str, ...]:
        """The attachments that can be read: colours by name, "depth" and "stencil"."""
        if not self.depth:
            return tuple(self.colors)
        return (*self.colors, "depth", *(("stencil",) if DEPTH[self.depth].stencil else ()))

    @abstractmethod
    def clear(self) -> None:
        """Set every attachment to its clear value, unmasked."""

    @abstractmethod
    def resolve(self) -> None:
        """Average the samples into what is read, if there are several a pixel."""

    @abstractmethod
    def sample_positions(self) -> Array:
        """Where the device takes a pixel's samples: (samples, 2), from its lower left corner.

        Raises:
            UnsupportedError: it does not say.
        """

    @abstractmethod
    def read(self, name: str) -> Image:
        """One attachment in its own components and type, row 0 at the bottom.

        "depth" is read as floats, whatever its format, "stencil" as unsigned bytes.

        Raises:
            UnsupportedError: depth or stencil of a multisampled target.
        """

    @abstractmethod
    def release(self) -> None:
        """Release all of its memory on the device; the target is of no use afterwards."""


COVERING = """#version 330 core
void main() {
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(corner, 0.0, 1.0);
}
"""
"""A vertex stage of one triangle over the whole target."""

UNREADABLE = "Target(samples=0): the depth of several samples a pixel has no one value"


def of_several_samples(name: str) -> UnsupportedError:
    """Why depth or stencil of a multisampled target is not read."""
    return UnsupportedError(f"reading the {name} of a multisampled target", remedy=UNREADABLE)


CAPACITY = 16


class Releasable(Protocol):
    """What holds memory of a device."""

    def release(self) -> None: ...


Program = TypeVar("Program", bound=Releasable)


class ProgramCache(Generic[Program]):
    """Programs by what they are made of, so that equal ones are made once.

    The `CAPACITY` most recently used ones are kept: a software driver's machine code takes a
    megabyte. A program is used before the next one is asked for.
    """

    def __init__(self, device: Any) -> None:
        self.device = device
        self._made: dict[Hashable, Program] = {}

    def get(self, key: Hashable, make: Callable[[], Program]) -> Program:
        """The program of this key; it is made now if there is none."""
        program = self._made.pop(key, None) or make()
        self._made[key] = program
        if len(self._made) > CAPACITY:
            self.drop(self._made.pop(next(iter(self._made))))
        return program

    def release(self) -> None:
        """Release all programs."""
        while self._made:
            self.drop(self._made.popitem()[1])

    def drop(self, program: Program) -> None:
        """Release a program that is kept no longer."""
        program.release()


Kind = TypeVar("Kind", bound=Attachments)
Made = TypeVar("Made", bound=ProgramCache[Any])


def plain_state(draw: PreparedDraw) -> State:
    """A draw's state without what changes the values that it writes: blending and masks."""
    return replace(draw.draw.state, blend=None, srgb=False, color_mask=(True,) * 4)


class PassSession(Session, Generic[Kind, Made]):
    """A session that draws its scene pass by pass; a backend says how each is done.

    Args:
        linker: makes the programs.
        scene: what to draw.
        programs: each pass's draws, compiled.
        size: (width, height) for targets that do not say.
        stack: releases device memory in the end.
    """

    _textures: SceneTextures[Any]  # what the scene's samplers read; a backend makes it

    def __init__(
        self, linker: Made, scene: Scene, programs: Programs, size: Size, stack: ExitStack
    ) -> None:
        super().__init__(scene, programs)
        self.linker = linker
        self.device = linker.device
        self.size = size
        self.stack = stack
        self.folder = Path(scene.case.file).parent
        self.bindings: dict[PassDraw, Bindings] = {}
        self.images: dict[tuple[str, str], Image] = {}
        self.targets: dict[str, Kind] = {}
        self._named = scene.outputs_named()
        self._gl_errors: dict[PassDraw, tuple[int, ...]] = {}
        self._inactive: set[str] = set()
        self._sample_positions: dict[str, Array] = {}
        self._captures: dict[str, PassCapture] = {}
        # They draw by this session: it and all its images would stay until cycles are collected.
        stack.callback(self._captures.clear)

    def draw(self, only: Container[str] | None = None) -> Drawn:
        for description in self.scene.passes:
            if only is None or description.name in only:
                self._run_pass(description)
        return Drawn(
            images=self.images,
            bindings=self.bindings,
            gl_errors=self._gl_errors,
            inactive=frozenset(self._inactive),
            sample_positions=self._sample_positions,
        )

    def attachment(self, pass_name: str, name: str) -> Image:
        if (pass_name, name) in self.images:
            return self.images[pass_name, name]
        self.reading()
        return self.targets[pass_name].read(name)

    answers: ClassVar[Answers] = {"attachment": attachment}

    def extent(self, description: Pass) -> Size:
        """The size in pixels of a pass's target."""
        return description.target.size or self.size

    def capture_fragments(self, key: PassDraw) -> Fragments:
        return self._capture(key[0]).fragments(key[1])

    def redraw_with_text(
        self, key: PassDraw, text: str, outputs: Mapping[str, str]
    ) -> Mapping[str, Array]:
        return self._capture(key[0]).written(key[1], text, outputs)

    def _capture(self, name: str) -> PassCapture:
        """The captures of a pass's draws. Those of one pass are kept: they are as large as
        pictures."""
        if name not in self._captures:
            self._captures.clear()
            draws, description = self.programs[name], self.scene.find_pass(name)

            def redrawn(texts: Sequence[str], colors: Mapping[str, str]) -> Mapping[str, Array]:
                plain = replace(description.target, colors=colors, clear=(0.0,) * 4, samples=0)
                return self.redrawn(description, plain, texts)

            self._captures[name] = PassCapture(draws, redrawn)
        return self._captures[name]

    @abstractmethod
    def redrawn(
        self, description: Pass, target: Target, texts: Sequence[str]
    ) -> Mapping[str, Array]:
        """The attachments of a pass that is drawn once more, each draw with another fragment text
        and in its `plain_state`."""

    def capture_vertices(self, key: PassDraw) -> Samples:
        draw = self.programs[key[0]][key[1]]
        return vertex_capture.vertices(draw, self.bindings[key], self.vertex_outputs)

    def probe(
        self,
        key: PassDraw,
        stage: Literal["vertex", "fragment"],
        runs: Sequence[Bindings],
        inputs: Mapping[str, Array],
    ) -> list[Samples]:
        draw = self.programs[key[0]][key[1]]
        if stage == "fragment":
            return self.probe_fragments(draw, runs, inputs)
        return [vertex_capture.probe(draw, each, inputs, self.vertex_outputs) for each in runs]

    @abstractmethod
    def probe_fragments(
        self, draw: PreparedDraw, runs: Sequence[Bindings], inputs: Mapping[str, Array]
    ) -> list[Samples]:
        """As `probe`, of the fragment stage."""

    @abstractmethod
    def vertex_outputs(
        self,
        draw: PreparedDraw,
        texts: Mapping[str, str],
        parts: Sequence[Piece],
        bindings: Bindings,
        count: int | None,
    ) -> Mapping[Piece, Array]:
        """As `shaderlab.drivers.programs.vertex_capture.Capture`."""

    def redraw_pass(self, changed: Pass, output: str, largest: int) -> Array:
        width, height = self.extent(changed)
        share = min(1.0, largest / max(width, height))
        if not any(draw.state.in_pixels for draw in changed.draws):
            width, height = round(width * share) or 1, round(height * share) or 1
        return self._drawn_again(changed, output, (width, height)).values

    def _drawn_again(self, description: Pass, output: str, size: Size) -> Image:
        """One attachment of a pass that is drawn once more, as described and in this size."""
        name = description.name
        colors, errors = dict(self.targets[name].colors), self._gl_errors
        target = self.make_target(description, colors, size)
        self._gl_errors = {}  # they were raised before, in the pass itself
        try:
            self.reading()
            target.clear()
            for index, draw in enumerate(self.programs[name]):
                state = description.draws[index].state
                other = replace(draw, draw=replace(draw.draw, state=state))
                self.issue((name, index), other, target)
            return target.read(output)
        finally:
            self._gl_errors = errors
            target.release()

    def bind(self, draw: PreparedDraw) -> Bindings:
        """The draw's uniforms and textures as the shader will get them."""
        return bind.bind(draw.draw, draw.interface, self._textures.texels)

    @abstractmethod
    def make_target(self, description: Pass, colors: dict[str, str], extent: Size) -> Kind:
        """What a pass draws into; `colors` are formats by output name."""

    @abstractmethod
    def issue(self, key: PassDraw, draw: PreparedDraw, target: Kind) -> None:
        """Draw; its bindings are made."""

    def compute(self, key: PassDraw, draw: PreparedDraw) -> None:
        """Run a compute shader, and take what it leaves in its buffers for images of its pass."""
        raise UnsupportedError("compute passes: this backend has none")

    def at(self, pass_name: str, draw: int | None = None) -> None:
        """Note the pass and the draw that calls are made for from now on."""

    def reading(self) -> None:
        """Note that calls are the lab's own from now on: it reads what was drawn."""

    def finish(self) -> None:
        """Wait until all is drawn."""

    def _run_pass(self, description: Pass) -> None:
        """Draw one pass, then read its colour attachments, and depth or stencil if asked for."""
        draws = self.programs[description.name]
        if description.computes:
            self.at(description.name, 0)
            check_reads(self.scene, description, draws[0].draw, self.targets)
            self.compute((description.name, 0), draws[0])
            return
        with doing("draw", f"making the target of pass {description.name!r}"):
            target = self._target(description)
        for index, draw in enumerate(draws):
            key = (description.name, index)
            self.at(*key)
            check_reads(self.scene, description, draw.draw, self.targets)
            with doing("draw", step(key, draw)):
                self.bindings[key] = self.bind(draw)
                self.issue(key, draw, target)
        with doing("draw"):
            self.at(description.name)
            target.resolve()
            # Drivers draw when they are made to: a program that hangs, hangs here.
            self.finish()
        with doing("read", f"reading pass {description.name!r}"):
            self.reading()
            self._read(description, target)

    def _target(self, description: Pass) -> Kind:
        """A target of the pass's own, cleared, or the one that it goes on in."""
        colors = dict(pass_colors(description, self.programs[description.name]))
        self.at(description.name)
        if description.onto:
            earlier = {name: target.colors for name, target in self.targets.items()}
            check_continues(self.scene, description, colors, earlier)
            target = self.targets[description.onto]
        else:
            target = self.make_target(description, colors, self.extent(description))
            self.stack.callback(target.release)
            target.clear()
        self.targets[description.name] = target
        if description.target.samples:
            self.reading()
            self._sample_positions[description.name] = target.sample_positions()
        return target

    def _read(self, description: Pass, target: Kind) -> None:
        kinds = output_types(self.programs[description.name])
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


class RedrawingSession(PassSession[Kind, Made], Generic[Kind, Made]):
    """A session that captures what fragment shaders got."""

    @abstractmethod
    def new_target(self, target: Target, colors: Mapping[str, str], size: Size) -> Kind:
        """Attachments; `colors` are formats by output name, in the order of their locations."""

    @abstractmethod
    def render(
        self,
        draw: PreparedDraw,
        bindings: Bindings,
        target: Kind,
        *,
        texts: Mapping[str, str] | None = None,
        fixed_state: State | None = None,
    ) -> None:
        """Draw into a target, and wait until it is drawn.

        Args:
            draw: what to draw.
            bindings: its uniforms and textures.
            target: what to draw into.
            texts: the stages' texts where they are others than its own.
            fixed_state: another state in place of its own.

        Raises:
            UnsupportedError: the API, or the device, has no such thing; the message names it.
        """

    def numbered(self, text: str, bindings: Bindings, index: int) -> tuple[str, Bindings]:
        """A text that is to have its draw's number in its pass, and the draw's bindings."""
        return numbered(text, index), bindings

    def fresh_target(self, pass_name: str) -> Kind:
        """A further target like that of a pass. Raises UnsupportedError for one that draws
        nothing."""
        description = self.scene.find_pass(pass_name)
        if description.computes:
            raise UnsupportedError(f"drawing pass {pass_name!r} once more: it is a dispatch")
        colors = pass_colors(description, self.programs[pass_name])
        return self.new_target(description.target, colors, self.extent(description))

    def make_target(self, description: Pass, colors: dict[str, str], extent: Size) -> Kind:
        return self.new_target(description.target, colors, extent)

    def issue(self, key: PassDraw, draw: PreparedDraw, target: Kind) -> None:
        self.render(draw, self.bindings[key], target)

    def probe_fragments(
        self, draw: PreparedDraw, runs: Sequence[Bindings], inputs: Mapping[str, Array]
    ) -> list[Samples]:
        probe = fragment_probe(draw, inputs)
        found = []
        # Where no point is discarded, each run writes all that is read.
        for some in [[run] for run in runs] if probe.discards else [runs]:
            with self.new_target(probe.target, probe.colors, probe.size) as target:
                found += [self._probed(probe, run, target) for run in some]
        return found

    def _probed(self, probe: FragmentProbe, bindings: Bindings, target: Kind) -> Samples:
        try:
            self.render(probe.draw, probe.bindings(bindings), target, texts=probe.texts)
        except ShaderError as error:
            raise refused(probe.subject, error.message) from error
        images = {name: target.read(name).values for name in probe.colors}
        kept = target.read("stencil").values if probe.discards else None
        return probe.samples(images, kept)

    def redrawn(
        self, description: Pass, target: Target, texts: Sequence[str]
    ) -> Mapping[str, Array]:
        name, colors = description.name, dict(target.colors or {})
        with self.new_target(target, colors, self.extent(description)) as made:
            for index, (draw, text) in enumerate(zip(self.programs[name], texts, strict=True)):
                own, bindings = self.numbered(text, self.bindings[name, index], index)
                stages = {**draw.texts, "fragment": own}
                self.render(draw, bindings, made, texts=stages, fixed_state=plain_state(draw))
            return {name: made.read(name).values for name in colors}
