"""The vertices that a draw hands to rasterisation, whatever writes them down. No device: the caller
draws."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Bindings, Samples
from shaderlab.model.mesh import Mesh
from shaderlab.model.state import State

from . import stages, tessellation
from .prepare import PreparedDraw
from .varyings import Piece, assembled
from .vertices import corners, entering, probed_mesh, vertex_inputs, vertex_pieces

Capture = Callable[
    [PreparedDraw, Mapping[str, str], Sequence[Piece], Bindings, int | None], Mapping[Piece, Array]
]
"""Draws with the stages of these texts, and gives the pieces of each vertex that comes out of the
last of them, (vertices, components), in the order of instances, primitives and emission; the number
is how many come out, or None where that is not known."""


def vertices(draw: PreparedDraw, bindings: Bindings, capture: Capture) -> Samples:
    """Every vertex that a draw of a mesh hands to rasterisation.

    Without a geometry shader each stored vertex is run once an instance, whatever the primitive;
    with one the mesh is drawn as it is, and every vertex that is emitted is captured.

    Outputs are gl_Position and every `out` variable, arrays and matrices as their elements and
    columns ("v[1]"). Inputs of a vertex stage are the attributes, gl_VertexID and gl_InstanceID.
    Inputs of a geometry stage are all outputs of the vertices of its primitive
    ("gl_in[0].gl_Position", "Normal[2]"), gl_PrimitiveIDIn, gl_InstanceID, and `emitted`, which
    counts the vertices that one invocation emits, from 0. Those vertices are `entering` of the
    samples, with gl_Position as "gl_in.gl_Position".

    Inputs of an evaluation stage are gl_TessCoord, gl_PrimitiveID, the levels, what the control
    stage made of its patch ("gl_in[0].gl_Position", "Normal[2]"), and the attributes of the patch's
    vertices ("aPos[0]"). What the control stage made is among the outputs, too.

    Raises:
        UnsupportedError: an output is of double precision, or a geometry stage follows an
            evaluation stage.
    """
    mesh = draw.draw.mesh
    assert mesh is not None
    given = _stored(draw, bindings, mesh, draw.draw.instances, capture)
    if draw.last_stage == "vertex":
        return given
    if draw.last_stage == "tess_evaluation":
        return _tessellated(draw, bindings, mesh, given, capture)
    if draw.draw.tess_evaluation is not None:
        raise UnsupportedError(
            f"capturing what {draw.draw.geometry} makes of tessellated patches",
            remedy="judge what is drawn of them, or draw them without the geometry stage",
        )
    return _emitted(draw, bindings, mesh, given, capture)


def probe(
    draw: PreparedDraw, bindings: Bindings, inputs: Mapping[str, Array], capture: Capture
) -> Samples:
    """Run the vertex stage on given inputs, each an array (count, components). Outputs are named as
    in `vertices`."""
    got = _stored(draw, bindings, probed_mesh(draw.draw, inputs), 1, capture)
    return got if draw.last_stage == "vertex" else _entering(got)


def _stored(
    draw: PreparedDraw, bindings: Bindings, mesh: Mesh, instances: int, capture: Capture
) -> Samples:
    text = {"vertex": draw.text("vertex") or ""}
    parts = vertex_pieces(text["vertex"], draw.vertex_interface)
    points = replace(draw, draw=replace(
        draw.draw, mesh=replace(mesh.made(), indices=None, primitive="points"),
        instances=instances, vertex_array=True, state=State(),
    ))  # fmt: skip
    got = capture(points, text, parts, bindings, mesh.vertices * instances)
    return Samples(
        inputs=vertex_inputs(mesh, instances), outputs={p.name + p.path: v for p, v in got.items()}
    )


def _emitted(
    draw: PreparedDraw, bindings: Bindings, mesh: Mesh, given: Samples, capture: Capture
) -> Samples:
    texts = {
        "vertex": stages.counting_vertex(draw.text("vertex") or ""),
        "geometry": stages.counting_geometry(draw.text("geometry") or ""),
    }
    counters = [Piece(name, "", "int") for name in stages.EMITTED.values()]
    parts = vertex_pieces(draw.text("geometry") or "", draw.interface)
    plain = replace(draw, draw=replace(draw.draw, vertex_array=True, state=State()))
    got = dict(capture(plain, texts, [*parts, *counters], bindings, None))
    source = {
        name: got.pop(counter) for name, counter in zip(stages.EMITTED, counters, strict=True)
    }
    which = corners(mesh)[source["gl_PrimitiveIDIn"][:, 0]]
    first = source["gl_InstanceID"] * mesh.vertices
    vertex = vertex_pieces(draw.text("vertex") or "", draw.vertex_interface)
    outputs = {piece: given.outputs[piece.name + piece.path] for piece in vertex}
    inputs: dict[str, Array] = dict(source)
    for name, values in assembled(outputs).items():
        for corner in range(which.shape[1]):
            inputs[_of_corner(name, corner)] = values[(first + which)[:, corner]]
    return Samples(
        inputs=inputs,
        outputs={p.name + p.path: v for p, v in got.items()},
        entering=_entering(given),
    )


def _tessellated(
    draw: PreparedDraw, bindings: Bindings, mesh: Mesh, given: Samples, capture: Capture
) -> Samples:
    text = draw.text("tess_evaluation") or ""
    plain = replace(draw, draw=replace(draw.draw, vertex_array=True, state=State()))
    outputs: dict[Piece, Array] = {}
    inputs: dict[Piece, Array] = {}
    for group in tessellation.groups(draw.interface):
        copying, copies = tessellation.copying(text, group)
        own = [] if outputs else vertex_pieces(text, draw.interface)
        texts = {stage: one for stage, one in draw.texts.items() if stage != "fragment"} | {
            "tess_evaluation": copying
        }
        got = dict(capture(plain, texts, [*own, *copies.values()], bindings, None))
        inputs |= {piece: got.pop(copy) for piece, copy in copies.items()}
        outputs |= got
    known = assembled(inputs)
    which = corners(mesh)[known["gl_PrimitiveID"][:, 0]]
    for name, values in mesh.attributes.items():
        for corner in range(which.shape[1]):
            known.setdefault(f"{name}[{corner}]", values[which[:, corner]])
    controlled = {piece: inputs[piece] for piece in tessellation.controlled(draw.interface)}
    written = {p.name + p.path: v for p, v in {**controlled, **outputs}.items()}
    return Samples(inputs=known, outputs=written, entering=_entering(given))


def _entering(given: Samples) -> Samples:
    """What a vertex stage gave, named as a geometry stage names it."""
    return replace(given, outputs={entering(n): v for n, v in given.outputs.items()})


def _of_corner(name: str, corner: int) -> str:
    """A vertex stage's output as a geometry shader has it of one vertex of its primitive."""
    if name.startswith("gl_"):
        return f"gl_in[{corner}].{name}"
    return re.sub(r"^\w+", rf"\g<0>[{corner}]", name)
