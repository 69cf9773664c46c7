"""What fragment shaders got, by drawing again with other texts: the same for every graphics API
that can draw a program of any text into a target of any attachments."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Generic

from shaderlab.errors import ShaderError, UnsupportedError
from shaderlab.model.frame import Array, Bindings, PassDraw, Samples
from shaderlab.model.scene import Pass, Target
from shaderlab.model.state import State

from . import Size
from .passes import Kind, Made, PassSession, plain_state
from .programs.fragment_capture import numbered
from .programs.fragment_probe import FragmentProbe, fragment_probe, refused
from .programs.prepare import PreparedDraw, pass_colors


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
        self, key: PassDraw, runs: Sequence[Bindings], inputs: Mapping[str, Array]
    ) -> list[Samples]:
        probe = fragment_probe(self.programs[key[0]][key[1]], inputs)
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
