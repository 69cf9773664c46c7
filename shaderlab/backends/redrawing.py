"""What fragment shaders got, by drawing again with other texts: the same for every graphics API
that can draw a program of any text into a target of any attachments."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Generic, Protocol, Self, TypeVar

from shaderlab.backends import Size
from shaderlab.backends.passes import Attachments, PassSession
from shaderlab.errors import ShaderError
from shaderlab.frame import Array, Bindings, Fragments, PassDraw, Samples
from shaderlab.model import Pass, State, Target
from shaderlab.programs import captures, fragment_capture
from shaderlab.programs.fragment_probe import fragment_probe, refused
from shaderlab.programs.prepare import PreparedDraw


class Temporary(Attachments, Protocol):
    """A target that can be cleared at the beginning of a `with` and released at its end."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...


Kind = TypeVar("Kind", bound=Temporary)


class RedrawingSession(PassSession[Kind], Generic[Kind]):
    """A session that captures what fragment shaders got.

    Attributes:
        cache: captured fragments across scenes.
    """

    cache: captures.CaptureCache

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

    def make_target(self, description: Pass, colors: dict[str, str], extent: Size) -> Kind:
        return self.new_target(description.target, colors, extent)

    def issue(self, key: PassDraw, draw: PreparedDraw, target: Kind) -> None:
        self.render(draw, self.bindings[key], target)

    def fragments(self, key: PassDraw) -> Fragments:
        """As `Session.fragments`. Arrays from the cache can't be written to (see
        `shaderlab.programs.captures`)."""
        draw = self.programs[key[0]][key[1]]
        same = captures.identity(self.scene, self.programs, key, self.size)
        return self.cache.get(
            same,
            lambda: fragment_capture.fragments(
                draw, lambda text, colors: self._redrawn(key, text, colors)
            ),
        )

    def written(self, key: PassDraw, text: str, outputs: Mapping[str, str]) -> Mapping[str, Array]:
        return fragment_capture.written(
            text, outputs, lambda text, colors: self._redrawn(key, text, colors)
        )

    def probe_fragments(
        self, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
    ) -> Samples:
        draw = self.programs[key[0]][key[1]]
        probe = fragment_probe(draw, inputs)
        with self.new_target(probe.target, probe.colors, probe.size) as target:
            given = probe.bindings(bindings)
            try:
                self.render(probe.draw, given, target, texts=probe.texts)
            except ShaderError as error:
                raise refused(draw, error.message) from error
            images = {name: target.read(name).values for name in probe.colors}
            kept = target.read("stencil").values if probe.discards else None
            return probe.samples(images, kept)

    def _redrawn(self, key: PassDraw, text: str, colors: Mapping[str, str]) -> Mapping[str, Array]:
        """The attachments of a pass whose draw `key` has another fragment text; other draws only
        say that they are seen, blending and masks are off."""
        description = self.scene.find_pass(key[0])
        plain = replace(description.target, colors=colors, clear=(0.0,) * 4, samples=0)
        with self.new_target(plain, colors, self.extent(description)) as target:
            for index, draw in enumerate(self.programs[key[0]]):
                own = text if index == key[1] else fragment_capture.blank(draw)
                self.render(
                    draw, self.bindings[key[0], index], target,
                    texts={**draw.texts, "fragment": own},
                    fixed_state=replace(
                        draw.draw.state, blend=None, srgb=False, color_mask=(True,) * 4
                    ),
                )  # fmt: skip
            return {name: target.read(name).values for name in colors}
