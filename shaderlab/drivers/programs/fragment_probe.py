"""Running a fragment stage on given inputs: each sample is a point of one pixel, so that nothing is
interpolated. No device: the caller draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Bindings, Samples
from shaderlab.model.mesh import Mesh
from shaderlab.model.scene import Target
from shaderlab.model.state import State, Stencil

from . import bind, formats, stages, vertex_stages
from .prepare import PreparedDraw

WIDTH = 256
"""Most points in a row of the target."""
_MAX_ATTRIBUTES = 16
_REMEDY = "judge it over the frame (formula, or value at a Pixel)"


@dataclass(frozen=True, kw_only=True)
class FragmentProbe:
    """What is to be drawn.

    Attributes:
        subject: the draw whose fragment stage is run.
        draw: the points, with that fragment stage.
        texts: its stages' texts.
        target: what it is drawn into, of `size` pixels.
        size: (width, height).
        colors: the attachments' formats by output.
        inputs: what each point gets, (count, components).
        discards: whether points may be discarded; then the stencil buffer counts those that are
            kept.
    """

    subject: PreparedDraw
    draw: PreparedDraw
    texts: Mapping[str, str]
    target: Target
    size: tuple[int, int]
    colors: Mapping[str, str]
    inputs: Mapping[str, Array]
    discards: bool

    def bindings(self, given: Bindings) -> Bindings:
        """The uniforms and textures of the subject, and what the points' own stage takes."""
        own = {stages.PREFIX + "size": np.array(self.size, np.int32)}
        return replace(given, uniforms={**given.uniforms, **own})

    def samples(self, images: Mapping[str, Array], stencil: Array | None) -> Samples:
        """What was drawn, by point."""
        count = max((len(values) for values in self.inputs.values()), default=1)
        kinds = self.subject.interface.outputs
        outputs = {
            name: values.reshape(-1, values.shape[-1])[
                :count, : formats.components_of(kinds[name].type)
            ]
            for name, values in images.items()
        }
        discarded = 0 if stencil is None else int((stencil.reshape(-1)[:count] == 0).sum())
        return Samples(inputs=self.inputs, outputs=outputs, discarded=discarded)


def fragment_probe(draw: PreparedDraw, inputs: Mapping[str, Array]) -> FragmentProbe:
    """Points that feed a draw's fragment stage these inputs, each an array (count, components);
    those that are not given take the value a domain has at the centre of the screen.

    Raises:
        CaseError: an input has no value, or is none of the shader's.
        UnsupportedError: the lab can't write a vertex stage that feeds the shader.
    """
    complete = bind.complete_inputs(draw.draw, draw.interface.varyings, inputs)
    count = max((len(values) for values in inputs.values()), default=1)
    width = min(count, WIDTH)
    text = draw.text("fragment") or ""
    vertex, columns = vertex_stages.probe_vertex(text, tuple(draw.interface.varyings.values()))
    if len(columns) > _MAX_ATTRIBUTES:
        raise UnsupportedError(
            f"running {draw.draw.fragment} on given inputs: it reads {len(columns)} vectors, "
            f"{_MAX_ATTRIBUTES} can be given",
            remedy=_REMEDY,
        )
    attributes = {name: bind.piece_of(complete, piece) for piece, name in columns.items()}
    attributes = attributes or {stages.PREFIX + "nothing": np.zeros((count, 1), np.float32)}
    # What is kept counts one up in the stencil buffer; a discarded point leaves its clear value.
    discards = stages.may_discard(text)
    points = replace(
        draw.draw, vertex="<probe>", geometry=None, domain=None, instances=1, vertex_array=True,
        mesh=Mesh(attributes=attributes, primitive="points"),
        state=State(stencil=Stencil(depth_pass="incr")) if discards else State(),
    )  # fmt: skip
    return FragmentProbe(
        subject=draw,
        draw=replace(draw, draw=points),
        texts={"vertex": vertex, "fragment": text},
        target=Target(depth="depth24_stencil8") if discards else Target(),
        size=(width, -(-count // width)),
        colors={n: formats.for_output(v.type) for n, v in draw.interface.outputs.items()},
        inputs=complete,
        discards=discards,
    )


def refused(draw: PreparedDraw, message: str) -> UnsupportedError:
    """The points' program does not compile."""
    return UnsupportedError(
        f"running {draw.draw.fragment} on given inputs: no vertex stage can be written that "
        f"declares them as it does ({message})",
        remedy=_REMEDY,
    )
