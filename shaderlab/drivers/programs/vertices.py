"""The vertices that a draw hands to rasterisation: their names, and the inputs they come from."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from shaderlab.compiler.interface import Interface
from shaderlab.model.frame import Array
from shaderlab.model.mesh import Mesh
from shaderlab.model.scene import Draw

from . import tessellation
from .prepare import PreparedDraw
from .varyings import Piece, elements, pieces

_CORNERS = {"points": 1, "lines": 2, "line_strip": 2, "triangles": 3}


def vertex_outputs(draw: PreparedDraw) -> list[str]:
    """The names that a captured vertex of a draw has: gl_Position and each output of its last
    stage before rasterisation, arrays and matrices as their elements and columns; then those of a
    vertex stage before further ones, with gl_Position as "gl_in.gl_Position". Of a tessellated
    patch also what the control stage gives, as the evaluation stage calls it."""
    last = [piece.name + piece.path for piece in vertex_pieces(draw.last_text, draw.interface)]
    if draw.last_stage == "vertex":
        return last
    if draw.last_stage == "tess_evaluation":
        last += [piece.name + piece.path for piece in tessellation.controlled(draw.interface)]
    pieces = vertex_pieces(draw.text("vertex") or "", draw.vertex_interface)
    return [*last, *(entering(piece.name + piece.path) for piece in pieces)]


def entering(name: str) -> str:
    """A vertex stage's output as a geometry stage after it calls it, whichever vertex it is of."""
    return f"gl_in.{name}" if name.startswith("gl_") else name


def vertex_pieces(text: str, interface: Interface) -> list[Piece]:
    """The same as pieces, of a stage with this text and interface."""
    built_in = [Piece("gl_Position", "", "vec4")]
    if re.search(r"\bgl_PointSize\b", text):
        built_in.append(Piece("gl_PointSize", "", "float"))
    declared = elements(interface.vertex_outputs.values())
    return [*built_in, *(piece for variable in declared for piece in pieces(variable))]


def vertex_inputs(mesh: Mesh, instances: int) -> dict[str, Array]:
    """What the vertex stage gets of a mesh: attributes, gl_VertexID and gl_InstanceID, each
    (instances · vertices, components)."""
    inputs = {
        name: np.tile(values, (instances, *(1,) * (values.ndim - 1)))
        for name, values in mesh.attributes.items()
    }
    for name, values in mesh.instance_attributes.items():
        inputs[name] = np.repeat(values, mesh.vertices, axis=0)
    inputs["gl_VertexID"] = np.tile(np.arange(mesh.vertices, dtype=np.int32), instances)[:, None]
    inputs["gl_InstanceID"] = np.repeat(np.arange(instances, dtype=np.int32), mesh.vertices)[
        :, None
    ]
    return inputs


def probed_mesh(draw: Draw, inputs: Mapping[str, Array]) -> Mesh:
    """A mesh of points with these attributes, (count, components); the others keep the values of
    the first vertex of the draw's own mesh."""
    assert draw.mesh is not None
    count = max((len(v) for v in inputs.values()), default=1)
    return Mesh(attributes={
        name: inputs[name] if name in inputs else np.repeat(values[:1], count, axis=0)
        for name, values in draw.mesh.inputs.items()
    })  # fmt: skip


def corners(mesh: Mesh) -> Array:
    """The stored vertices of each primitive, (primitives, 1…3, of patches 1…32), in the order in
    which the stages after the vertex stage get them. Source: OpenGL 4.5 core profile specification,
    table 10.1 and §10.1."""
    order = np.arange(mesh.vertices) if mesh.indices is None else np.asarray(mesh.indices)
    size = mesh.patch_vertices if mesh.primitive == "patches" else _CORNERS.get(mesh.primitive, 3)
    if mesh.primitive in ("points", "lines", "triangles", "patches"):
        return order[: len(order) // size * size].reshape(-1, size)
    count = max(len(order) - size + 1, 0)
    at = np.arange(count)
    if mesh.primitive == "line_strip":
        return np.stack([order[at], order[at + 1]], axis=1)
    if mesh.primitive == "triangle_fan":
        return np.stack([np.repeat(order[:1], count), order[at + 1], order[at + 2]], axis=1)
    odd = at % 2  # every other triangle of a strip is turned round, to keep its winding
    return np.stack([order[at + odd], order[at + 1 - odd], order[at + 2]], axis=1)
