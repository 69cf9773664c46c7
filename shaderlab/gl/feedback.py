"""What vertices come out of the last stage before rasterisation, by transform feedback.

Without a geometry shader each stored vertex is run once an instance, whatever the primitive; with
one the mesh is drawn as it is, and every vertex that is emitted is written down.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.frame import Array, Bindings, PassDraw, Samples
from shaderlab.gl import stages
from shaderlab.gl.prepare import PreparedDraw
from shaderlab.gl.recording import recorded
from shaderlab.gl.runner import Session
from shaderlab.gl.varyings import Piece, assembled, elements, pieces
from shaderlab.glsl.spirv import Interface
from shaderlab.model import Mesh

_CORNERS = {"points": 1, "lines": 2, "line_strip": 2, "triangles": 3}


def vertices(
    session: Session, key: PassDraw, bindings: Bindings | None = None, mesh: Mesh | None = None
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
    draw = session.prepared[key[0]][key[1]]
    bound = bindings or session.bindings[key]
    one_mesh = mesh or draw.draw.mesh
    assert one_mesh is not None
    if draw.draw.geometry is None or mesh is not None:
        count = draw.draw.instances if mesh is None else 1
        return _stored(session, draw, bound, one_mesh, count, draw.interface)
    return _emitted(session, draw, bound, one_mesh)


def names(draw: PreparedDraw) -> list[str]:
    """What `vertices` gives of a draw: gl_Position and its outputs, arrays and matrices as their
    elements and columns."""
    text = draw.text("geometry") or draw.text("vertex") or ""
    return [piece.name + piece.path for piece in _pieces(text, draw.interface)]


def probe_vertices(
    session: Session, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
) -> Samples:
    """Run the vertex stage on given attributes (count, components); the others keep the values
    of the mesh's first vertex.

    Raises:
        UnsupportedError: a geometry stage follows, which takes whole primitives.
    """
    draw = session.prepared[key[0]][key[1]].draw
    mesh = draw.mesh
    assert mesh is not None
    if draw.geometry is not None:
        raise UnsupportedError(
            f"running {draw.geometry} on given inputs: a geometry stage takes whole primitives",
            remedy="judge what it emits of the mesh (formula), with a mesh that has these inputs",
        )
    count = max((len(v) for v in inputs.values()), default=1)
    attributes = {
        name: inputs[name] if name in inputs else np.repeat(values[:1], count, axis=0)
        for name, values in mesh.inputs.items()
    }
    return vertices(session, key, bindings, Mesh(attributes=attributes))


def corners(mesh: Mesh) -> Array:
    """The stored vertices of each primitive, (primitives, 1…3), in the order in which a geometry
    shader gets them. Source: OpenGL 4.5 core profile specification, table 10.1 and §10.1."""
    order = np.arange(mesh.vertices) if mesh.indices is None else np.asarray(mesh.indices)
    size = _CORNERS.get(mesh.primitive, 3)
    if mesh.primitive in ("points", "lines", "triangles"):
        return order[: len(order) // size * size].reshape(-1, size)
    count = max(len(order) - size + 1, 0)
    at = np.arange(count)
    if mesh.primitive == "line_strip":
        return np.stack([order[at], order[at + 1]], axis=1)
    if mesh.primitive == "triangle_fan":
        return np.stack([np.repeat(order[:1], count), order[at + 1], order[at + 2]], axis=1)
    odd = at % 2  # every other triangle of a strip is turned round, to keep its winding
    return np.stack([order[at + odd], order[at + 1 - odd], order[at + 2]], axis=1)


def _stored(
    session: Session,
    draw: PreparedDraw,
    bindings: Bindings,
    mesh: Mesh,
    instances: int,
    interface: Interface,
) -> Samples:
    text = {"vertex": draw.text("vertex") or ""}
    parts = _pieces(text["vertex"], interface)
    points = replace(draw, draw=replace(
        draw.draw, mesh=replace(mesh.made(), indices=None, primitive="points"), instances=instances
    ))  # fmt: skip
    got = recorded(session, points, text, parts, bindings, mesh.vertices * instances)
    repeated = {
        name: np.tile(values, (instances, *(1,) * (values.ndim - 1)))
        for name, values in mesh.attributes.items()
    }
    for name, values in mesh.instance_attributes.items():
        repeated[name] = np.repeat(values, mesh.vertices, axis=0)
    repeated["gl_VertexID"] = np.tile(np.arange(mesh.vertices, dtype=np.int32), instances)[:, None]
    repeated["gl_InstanceID"] = np.repeat(np.arange(instances, dtype=np.int32), mesh.vertices)[
        :, None
    ]
    return Samples(inputs=repeated, outputs={p.name + p.path: v for p, v in got.items()})


def _emitted(session: Session, draw: PreparedDraw, bindings: Bindings, mesh: Mesh) -> Samples:
    instances = draw.draw.instances
    given = _stored(session, draw, bindings, mesh, instances, draw.vertex_interface)
    texts = {
        "vertex": stages.counting_vertex(draw.text("vertex") or ""),
        "geometry": stages.counting_geometry(draw.text("geometry") or ""),
    }
    counters = [Piece(name, "", "int") for name in stages.EMITTED.values()]
    parts = _pieces(texts["geometry"], draw.interface)
    got = recorded(session, draw, texts, [*parts, *counters], bindings, None)
    source = {
        name: got.pop(counter) for name, counter in zip(stages.EMITTED, counters, strict=True)
    }
    which = corners(mesh)[source["gl_PrimitiveIDIn"][:, 0]]
    first = source["gl_InstanceID"] * mesh.vertices
    outputs = {piece: given.outputs[piece.name + piece.path]
               for piece in _pieces(draw.text("vertex") or "", draw.vertex_interface)}  # fmt: skip
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


def _pieces(text: str, interface: Interface) -> list[Piece]:
    built_in = [Piece("gl_Position", "", "vec4")]
    if re.search(r"\bgl_PointSize\b", text):
        built_in.append(Piece("gl_PointSize", "", "float"))
    declared = elements(interface.vertex_outputs.values())
    return [*built_in, *(piece for variable in declared for piece in pieces(variable))]
