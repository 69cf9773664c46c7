"""The vertices that a draw hands to rasterisation: their names, and the inputs they come from."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from shaderlab.compiler.reflection import Interface
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Bindings, Samples
from shaderlab.model.mesh import Mesh
from shaderlab.model.scene import Draw
from shaderlab.model.state import State

from . import stages
from .prepare import PreparedDraw
from .stages import VaryingPart, array_elements, join_parts, split_parts

_CORNERS = {"points": 1, "lines": 2, "line_strip": 2, "triangles": 3}


def vertex_output_names(draw: PreparedDraw) -> list[str]:
    """The names that a captured vertex of a draw has: gl_Position and each output of its last
    stage before rasterisation, arrays and matrices as their elements and columns; then those of a
    vertex stage before further ones, with gl_Position as "gl_in.gl_Position". Of a tessellated
    patch also what the control stage gives, as the evaluation stage calls it."""
    last = [piece.name + piece.path for piece in vertex_parts(draw.last_text, draw.interface)]
    if draw.last_stage == "vertex":
        return last
    if draw.last_stage == "tess_evaluation":
        last += [piece.name + piece.path for piece in stages.control_outputs(draw.interface)]
    pieces = vertex_parts(draw.text("vertex") or "", draw.vertex_interface)
    return [*last, *(entering_name(piece.name + piece.path) for piece in pieces)]


def entering_name(name: str) -> str:
    """A vertex stage's output as a geometry stage after it calls it, whichever vertex it is of."""
    return f"gl_in.{name}" if name.startswith("gl_") else name


def vertex_parts(text: str, interface: Interface) -> list[VaryingPart]:
    """The same as pieces, of a stage with this text and interface."""
    built_in = [VaryingPart("gl_Position", "", "vec4")]
    if re.search(r"\bgl_PointSize\b", text):
        built_in.append(VaryingPart("gl_PointSize", "", "float"))
    declared = array_elements(interface.vertex_outputs.values())
    return [*built_in, *(piece for variable in declared for piece in split_parts(variable))]


def mesh_inputs(mesh: Mesh, instances: int) -> dict[str, Array]:
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


def make_probe_mesh(draw: Draw, inputs: Mapping[str, Array]) -> Mesh:
    """A mesh of points with these attributes, (count, components); the others keep the values of
    the first vertex of the draw's own mesh."""
    assert draw.mesh is not None
    count = max((len(v) for v in inputs.values()), default=1)
    return Mesh(attributes={
        name: inputs[name] if name in inputs else np.repeat(values[:1], count, axis=0)
        for name, values in draw.mesh.inputs.items()
    })  # fmt: skip


def primitive_corners(mesh: Mesh) -> Array:
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


Capture = Callable[
    [PreparedDraw, Mapping[str, str], Sequence[VaryingPart], Bindings, int | None],
    Mapping[VaryingPart, Array],
]
"""Draws with the stages of these texts, and gives the pieces of each vertex that comes out of the
last of them, (vertices, components), in the order of instances, primitives and emission; the number
is how many come out, or None where that is not known."""


def capture_vertices(draw: PreparedDraw, bindings: Bindings, capture: Capture) -> Samples:
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
    given = _run_vertices(draw, bindings, mesh, draw.draw.instances, capture)
    if draw.last_stage == "vertex":
        return given
    if draw.last_stage == "tess_evaluation":
        return _capture_tessellated(draw, bindings, mesh, given, capture)
    if draw.draw.tess_evaluation is not None:
        raise UnsupportedError(
            f"capturing what {draw.draw.geometry} makes of tessellated patches",
            remedy="judge what is drawn of them, or draw them without the geometry stage",
        )
    return _capture_emitted(draw, bindings, mesh, given, capture)


def probe_vertices(
    draw: PreparedDraw, bindings: Bindings, inputs: Mapping[str, Array], capture: Capture
) -> Samples:
    """Run the vertex stage on given inputs, each an array (count, components). Outputs are named as
    in `vertices`."""
    got = _run_vertices(draw, bindings, make_probe_mesh(draw.draw, inputs), 1, capture)
    return got if draw.last_stage == "vertex" else _rename_entering(got)


def _run_vertices(
    draw: PreparedDraw, bindings: Bindings, mesh: Mesh, instances: int, capture: Capture
) -> Samples:
    text = {"vertex": draw.text("vertex") or ""}
    parts = vertex_parts(text["vertex"], draw.vertex_interface)
    points = replace(draw, draw=replace(
        draw.draw, mesh=replace(mesh.made(), indices=None, primitive="points"),
        instances=instances, vertex_array=True, state=State(),
    ))  # fmt: skip
    got = capture(points, text, parts, bindings, mesh.vertices * instances)
    return Samples(
        inputs=mesh_inputs(mesh, instances), outputs={p.name + p.path: v for p, v in got.items()}
    )


def _capture_emitted(
    draw: PreparedDraw, bindings: Bindings, mesh: Mesh, given: Samples, capture: Capture
) -> Samples:
    texts = {
        "vertex": stages.pass_instance_on(draw.text("vertex") or ""),
        "geometry": stages.count_emitted(draw.text("geometry") or ""),
    }
    counters = [VaryingPart(name, "", "int") for name in stages.EMITTED.values()]
    parts = vertex_parts(draw.text("geometry") or "", draw.interface)
    plain = replace(draw, draw=replace(draw.draw, vertex_array=True, state=State()))
    got = dict(capture(plain, texts, [*parts, *counters], bindings, None))
    source = {
        name: got.pop(counter) for name, counter in zip(stages.EMITTED, counters, strict=True)
    }
    which = primitive_corners(mesh)[source["gl_PrimitiveIDIn"][:, 0]]
    first = source["gl_InstanceID"] * mesh.vertices
    vertex = vertex_parts(draw.text("vertex") or "", draw.vertex_interface)
    outputs = {piece: given.outputs[piece.name + piece.path] for piece in vertex}
    inputs: dict[str, Array] = dict(source)
    for name, values in join_parts(outputs).items():
        for corner in range(which.shape[1]):
            inputs[_corner_name(name, corner)] = values[(first + which)[:, corner]]
    return Samples(
        inputs=inputs,
        outputs={p.name + p.path: v for p, v in got.items()},
        entering=_rename_entering(given),
    )


def _capture_tessellated(
    draw: PreparedDraw, bindings: Bindings, mesh: Mesh, given: Samples, capture: Capture
) -> Samples:
    text = draw.text("tess_evaluation") or ""
    plain = replace(draw, draw=replace(draw.draw, vertex_array=True, state=State()))
    outputs: dict[VaryingPart, Array] = {}
    inputs: dict[VaryingPart, Array] = {}
    for group in stages.group_inputs(draw.interface):
        copying, copies = stages.copy_inputs(text, group)
        own = [] if outputs else vertex_parts(text, draw.interface)
        texts = {stage: one for stage, one in draw.texts.items() if stage != "fragment"} | {
            "tess_evaluation": copying
        }
        got = dict(capture(plain, texts, [*own, *copies.values()], bindings, None))
        inputs |= {piece: got.pop(copy) for piece, copy in copies.items()}
        outputs |= got
    known = join_parts(inputs)
    which = primitive_corners(mesh)[known["gl_PrimitiveID"][:, 0]]
    for name, values in mesh.attributes.items():
        for corner in range(which.shape[1]):
            known.setdefault(f"{name}[{corner}]", values[which[:, corner]])
    controlled = {piece: inputs[piece] for piece in stages.control_outputs(draw.interface)}
    written = {p.name + p.path: v for p, v in {**controlled, **outputs}.items()}
    return Samples(inputs=known, outputs=written, entering=_rename_entering(given))


def _rename_entering(given: Samples) -> Samples:
    """What a vertex stage gave, named as a geometry stage names it."""
    return replace(given, outputs={entering_name(n): v for n, v in given.outputs.items()})


def _corner_name(name: str, corner: int) -> str:
    """A vertex stage's output as a geometry shader has it of one vertex of its primitive."""
    if name.startswith("gl_"):
        return f"gl_in[{corner}].{name}"
    return re.sub(r"^\w+", rf"\g<0>[{corner}]", name)
