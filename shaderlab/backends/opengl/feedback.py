"""What vertices come out of the last stage before rasterisation, by transform feedback.

Without a geometry shader each stored vertex is run once an instance, whatever the primitive; with
one the mesh is drawn as it is, and every vertex that is emitted is written down.
"""

from __future__ import annotations

import re
from dataclasses import replace

from shaderlab.backends.opengl.drawing import Drawing
from shaderlab.backends.opengl.recording import recorded
from shaderlab.frame import Array, Bindings, PassDraw, Samples
from shaderlab.glsl.interface import Interface
from shaderlab.model import Mesh
from shaderlab.programs import stages
from shaderlab.programs.prepare import PreparedDraw
from shaderlab.programs.varyings import Piece, assembled
from shaderlab.programs.vertices import corners, vertex_inputs, vertex_pieces


def vertices(
    drawing: Drawing, key: PassDraw, bindings: Bindings | None = None, mesh: Mesh | None = None
) -> Samples:
    """Every vertex that a draw (or a mesh in place of its own) hands to rasterisation.

    Outputs are gl_Position and every `out` variable, arrays and matrices as their elements and
    columns ("v[1]"). Inputs of a vertex stage are the attributes, gl_VertexID and gl_InstanceID.
    Inputs of a geometry stage are all outputs of the vertices of its primitive
    ("gl_in[0].gl_Position", "Normal[2]"), gl_PrimitiveIDIn, gl_InstanceID, and `emitted`, which
    counts the vertices that one invocation emits, from 0.

    Raises:
        UnsupportedError: an output is of double precision.
        DriverError: the driver writes down fewer vertices than it says there are.
    """
    draw = drawing.programs[key[0]][key[1]]
    bound = bindings or drawing.bindings[key]
    one_mesh = mesh or draw.draw.mesh
    assert one_mesh is not None
    if draw.draw.geometry is None or mesh is not None:
        count = draw.draw.instances if mesh is None else 1
        return _stored(drawing, draw, bound, one_mesh, count, draw.interface)
    return _emitted(drawing, draw, bound, one_mesh)


def _stored(
    drawing: Drawing,
    draw: PreparedDraw,
    bindings: Bindings,
    mesh: Mesh,
    instances: int,
    interface: Interface,
) -> Samples:
    text = {"vertex": draw.text("vertex") or ""}
    parts = vertex_pieces(text["vertex"], interface)
    points = replace(draw, draw=replace(
        draw.draw, mesh=replace(mesh.made(), indices=None, primitive="points"), instances=instances
    ))  # fmt: skip
    got = recorded(drawing, points, text, parts, bindings, mesh.vertices * instances)
    return Samples(
        inputs=vertex_inputs(mesh, instances), outputs={p.name + p.path: v for p, v in got.items()}
    )


def _emitted(drawing: Drawing, draw: PreparedDraw, bindings: Bindings, mesh: Mesh) -> Samples:
    instances = draw.draw.instances
    given = _stored(drawing, draw, bindings, mesh, instances, draw.vertex_interface)
    texts = {
        "vertex": stages.counting_vertex(draw.text("vertex") or ""),
        "geometry": stages.counting_geometry(draw.text("geometry") or ""),
    }
    counters = [Piece(name, "", "int") for name in stages.EMITTED.values()]
    parts = vertex_pieces(texts["geometry"], draw.interface)
    got = recorded(drawing, draw, texts, [*parts, *counters], bindings, None)
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
    return Samples(inputs=inputs, outputs={p.name + p.path: v for p, v in got.items()})


def _of_corner(name: str, corner: int) -> str:
    """A vertex stage's output as a geometry shader has it of one vertex of its primitive."""
    if name.startswith("gl_"):
        return f"gl_in[{corner}].{name}"
    return re.sub(r"^\w+", rf"\g<0>[{corner}]", name)
