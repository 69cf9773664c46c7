"""Capturing what the stages of a draw got and gave, and running them on given inputs. Nothing here
touches a device: the caller draws.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from shaderlab.compiler.reflection import Interface
from shaderlab.errors import ShaderError, UnsupportedError
from shaderlab.model.frame import Array, Bindings, Fragments, Samples, leading
from shaderlab.model.mesh import Mesh
from shaderlab.model.scene import Draw, Target
from shaderlab.model.state import State, Stencil

from . import bind, stages, textures
from .prepare import PreparedDraw
from .stages import VaryingPart, array_elements, join_parts, split_parts

WIDTH = 256
"""Most points in a row of the target."""
_MAX_ATTRIBUTES = 16
_REMEDY = "judge it over the frame (formula, or value at a Pixel)"


Texts = Mapping[str, str]
"""The texts of a draw's stages."""
Parts = Sequence[VaryingPart]
Captured = Mapping[VaryingPart, Array]
Probed = Literal["vertex", "fragment"]

DrawPoints = Callable[
    [PreparedDraw, Bindings, Target, Mapping[str, str], tuple[int, int]], Mapping[str, Array]
]
"""Draws points with their uniforms and textures into a target, with colours (format by output) and
a size; gives the colours and the stencil, if there is one."""


def probe_fragments(
    draw: PreparedDraw,
    runs: Sequence[Bindings],
    inputs: Mapping[str, Array],
    draw_points: DrawPoints,
) -> list[Samples]:
    """Run a draw's fragment stage on inputs, each an array (count, components), once with the
    uniforms and textures of each of `runs`: every row is a point of one pixel, so that nothing is
    interpolated. Inputs that are not given take the value that a domain has at the centre of the
    screen. Raises CaseError: an input has no value, or is none of the shader's; UnsupportedError:
    the lab can't write a vertex stage that feeds the shader."""
    complete = bind.complete_inputs(draw.draw, draw.interface.varyings, inputs)
    count = max((len(values) for values in inputs.values()), default=1)
    width = min(count, WIDTH)
    size = (width, -(-count // width))
    discards = "discard" in draw.text("fragment")
    probe = _points_of(draw, complete, count, discards)
    target = Target(depth="depth24_stencil8") if discards else Target()
    outputs = draw.interface.outputs
    colors = {name: textures.output_format(output.type) for name, output in outputs.items()}
    samples = []
    for run in runs:
        own = {stages.PREFIX + "size": np.array(size, np.int32)}
        bindings = replace(run, uniforms={**run.uniforms, **own})
        try:
            images = draw_points(probe, bindings, target, colors, size)
        except ShaderError as error:
            raise UnsupportedError(
                f"running {draw.draw.fragment} on given inputs: no vertex stage can be written "
                f"that declares them as it does ({error.message})",
                remedy=_REMEDY,
            ) from error
        rows = {
            name: values.reshape(-1, values.shape[-1])[:count] for name, values in images.items()
        }
        sizes = {name: textures.components_of(output.type) for name, output in outputs.items()}
        written = {name: rows[name][:, :size] for name, size in sizes.items()}
        discarded = int((rows["stencil"] == 0).sum()) if discards else 0
        samples.append(Samples(inputs=complete, outputs=written, discarded=discarded))
    return samples


def _points_of(
    draw: PreparedDraw, inputs: Mapping[str, Array], count: int, discards: bool
) -> PreparedDraw:
    """Return the draw as points, each with its row of the inputs; where the stage may discard,
    points that it keeps count one up in the stencil buffer."""
    text = draw.text("fragment")
    vertex, columns = stages.write_probe_stage(text, tuple(draw.interface.varyings.values()))
    if len(columns) > _MAX_ATTRIBUTES:
        raise UnsupportedError(
            f"running {draw.draw.fragment} on given inputs: it reads {len(columns)} vectors, "
            f"{_MAX_ATTRIBUTES} can be given",
            remedy=_REMEDY,
        )
    attributes = {name: bind.select_part(inputs, part) for part, name in columns.items()}
    attributes = attributes or {stages.PREFIX + "nothing": np.zeros((count, 1), np.float32)}
    points = replace(
        draw.draw,
        vertex="<probe>",
        geometry=None,
        domain=None,
        instances=1,
        vertex_array=True,
        mesh=Mesh(attributes=attributes, primitive="points"),
        state=State(stencil=Stencil(depth_pass="incr")) if discards else State(),
    )
    return replace(draw, draw=points, rewritten={"vertex": vertex, "fragment": text})


Redraw = Callable[[Sequence[str], Mapping[str, str]], Mapping[str, Array]]
"""Draws a pass once more, its first draws each with another of these fragment texts, into
attachments of these formats by name; gives what they hold."""


@dataclass(frozen=True)
class SharedCapture:
    """What one redraw of a pass left of several draws: attachments, and by draw those of them that
    hold the pieces of its inputs."""

    images: Mapping[str, Array]
    pieces: Mapping[int, Mapping[VaryingPart, str]]

    def fragments(self, index: int) -> Fragments:
        """Return what one of the draws got."""
        coord, number = self.images[stages.COORD], self.images[stages.NUMBERED][..., 0]
        covered = (coord[..., 3] > 0.0) & (number == index + 1)
        others = np.where(coord[..., 3:] != 0.0, np.array([0, 0, 0, -1], np.float32), np.float32(0))
        values = {
            piece: leading(self.images[name], textures.components_of(piece.type))
            for piece, name in self.pieces[index].items()
        }
        place = np.where(covered[..., None], coord, others)
        return Fragments(covered=covered, frag_coord=place, inputs=join_parts(values))


def capture_together(
    draws: Sequence[PreparedDraw], index: int, redraw: Redraw
) -> SharedCapture | None:
    """Capture a draw, and with it all others of its pass whose inputs fit into the same
    attachments; None where it can only be captured by itself."""
    together: dict[int, Sequence[VaryingPart]] = {}
    types: list[str] = []  # of the attachments
    try:
        for number in sorted(range(len(draws)), key=lambda each: each != index):
            text, interface = draws[number].text("fragment"), draws[number].interface
            parts = stages.fragment_input_parts(text, interface.varyings.values())
            own = [stages.attachment_type(piece) for piece in parts]
            fits = len(interface.outputs) + len(own) + 2 <= stages.MOST_OUTPUTS
            if fits and own[: len(types)] == types[: len(own)]:
                types = max(types, own, key=len)
                together[number] = parts
        if index not in together or len(together) < 2:
            return None
        texts, pieces = [_write_blank(draw) for draw in draws], {}
        for number, inputs in together.items():
            texts[number], pieces[number] = stages.capture_fragment(
                draws[number].text("fragment"), inputs, numbered=True
            )
        colors = {stages.COORD: "rgba32f", stages.NUMBERED: "r32f"}
        colors |= {f"{stages.PREFIX}out{n}": textures.output_format(t) for n, t in enumerate(types)}
        return SharedCapture(redraw(texts, colors), pieces)
    except (ShaderError, UnsupportedError):  # another one may be what the driver refuses
        return None


def capture_fragments(
    draws: Sequence[PreparedDraw], index: int, redraw: Redraw, shared: SharedCapture | None = None
) -> Fragments:
    """Return what the fragment shader of one of a pass's draws got, at each pixel that the draw was
    the last to write; `shared` is what was captured of it together with others.

    The pass's other draws run as well and wipe out what they cover, so `covered` is what is seen of
    the draw in the end. A shader that may keep fragments out is captured a second time keeping them
    all. Raises UnsupportedError: the fragment shader has so many outputs that none can be added,
    and they are declared in a way that leaves none out."""
    found = _capture(draws, index, redraw) if shared is None else shared.fragments(index)
    text = draws[index].text("fragment")
    if "discard" not in text and "gl_FragDepth" not in text:
        return found
    return replace(found, undiscarded=_capture(draws, index, redraw, keep_all=True))


def redraw_with_text(
    draws: Sequence[PreparedDraw], index: int, redraw: Redraw, text: str, outputs: Mapping[str, str]
) -> Mapping[str, Array]:
    """Redraw a pass up to one draw, with another fragment text for that; returns these outputs of
    it (formats by name), 0 where it leaves none."""
    ending, _ = stages.capture_fragment(text, (), calls=True)
    texts = _with_blanks(draws[: index + 1], index, ending)  # to compile each state takes time
    images = redraw(texts, {**outputs, stages.COORD: "rgba32f"})
    unseen = images[stages.COORD][..., 3:] <= 0.0
    for name in outputs:
        np.copyto(images[name], 0, where=unseen)
    return {name: images[name] for name in outputs}


def _capture(
    draws: Sequence[PreparedDraw], index: int, redraw: Redraw, *, keep_all: bool = False
) -> Fragments:
    """Capture one draw, among others that only mark where they are seen."""
    draw = draws[index]
    text, outputs = draw.text("fragment"), draw.interface.outputs
    parts = stages.fragment_input_parts(text, draw.interface.varyings.values())
    crowded = len(outputs) + 2 > stages.MOST_OUTPUTS  # a place and an input do not fit beside them
    room = stages.MOST_OUTPUTS - 1 - (0 if crowded else len(outputs))
    values: dict[VaryingPart, Array] = {}
    for start in range(0, max(len(parts), 1), room):
        made, captured = stages.capture_fragment(
            text, parts[start : start + room], outputs if crowded else (), keep_all=keep_all
        )
        colors = {stages.COORD: "rgba32f"}
        for piece, name in captured.items():
            colors[name] = textures.output_format(stages.attachment_type(piece))
        images = redraw(_with_blanks(draws, index, made), colors)
        for piece, name in captured.items():
            values[piece] = leading(images[name], textures.components_of(piece.type))
    coord = images[stages.COORD]
    return Fragments(covered=coord[..., 3] > 0.0, frag_coord=coord, inputs=join_parts(values))


def _with_blanks(draws: Sequence[PreparedDraw], index: int, text: str) -> list[str]:
    """Return the fragment texts of a redraw: one draw's, and for the others texts that only mark
    where they are seen, by −1 for 1/w."""
    return [text if number == index else _write_blank(draw) for number, draw in enumerate(draws)]


def _write_blank(draw: PreparedDraw) -> str:
    outputs = draw.interface.outputs
    unwanted = outputs if len(outputs) + 1 > stages.MOST_OUTPUTS else ()
    text, _ = stages.capture_fragment(draw.text("fragment"), (), unwanted)
    return text.replace(
        f"{stages.COORD} = gl_FragCoord;", f"{stages.COORD} = vec4(0.0, 0.0, 0.0, -1.0);"
    )


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
    pieces = vertex_parts(draw.text("vertex"), draw.vertex_interface)
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
    first = {name: np.repeat(v[:1], count, axis=0) for name, v in draw.mesh.inputs.items()}
    return Mesh(attributes={name: inputs.get(name, values) for name, values in first.items()})


def primitive_corners(mesh: Mesh) -> Array:
    """The stored vertices of each primitive, (primitives, 1…3, of patches 1…32), in the order of
    later stages. Source: OpenGL 4.5 core profile specification, §10.1, table 10.1."""
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


CaptureOutputs = Callable[[PreparedDraw, Texts, Parts, Bindings, int | None], Captured]
"""Draws with the stages of these texts, and gives the pieces of each vertex that comes out of the
last of them, (vertices, components), in the order of instances, primitives and emission; the number
is how many come out, or None where that is not known."""


def capture_vertices(draw: PreparedDraw, bindings: Bindings, capture: CaptureOutputs) -> Samples:
    """Capture every vertex that a draw of a mesh hands to rasterisation.

    Without a geometry shader each stored vertex is run once an instance, whatever the primitive;
    with one the mesh is drawn as it is, and every emitted vertex is captured.

    Outputs are gl_Position and every `out` variable, arrays and matrices as their elements and
    columns ("v[1]"). Inputs of a vertex stage are the attributes, gl_VertexID and gl_InstanceID; of
    a geometry stage the outputs of its primitive's vertices ("gl_in[0].gl_Position", "Normal[2]"),
    gl_PrimitiveIDIn, gl_InstanceID, and `emitted`, which counts an invocation's vertices from 0; of
    an evaluation stage gl_TessCoord, gl_PrimitiveID, the attributes of the patch's vertices
    ("aPos[0]"), the levels and what the control stage made, which are among the outputs, too.
    `entering` are the vertices before a further stage, with gl_Position as "gl_in.gl_Position".
    Raises UnsupportedError: an output is of double precision, or a geometry stage follows an
    evaluation stage."""
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
    draw: PreparedDraw, bindings: Bindings, inputs: Mapping[str, Array], capture: CaptureOutputs
) -> Samples:
    """Run the vertex stage on inputs (count, components). Outputs are named as in `vertices`."""
    got = _run_vertices(draw, bindings, make_probe_mesh(draw.draw, inputs), 1, capture)
    return got if draw.last_stage == "vertex" else _rename_entering(got)


def _run_vertices(
    draw: PreparedDraw, bindings: Bindings, mesh: Mesh, instances: int, capture: CaptureOutputs
) -> Samples:
    text = {"vertex": draw.text("vertex")}
    parts = vertex_parts(text["vertex"], draw.vertex_interface)
    dots = replace(mesh.made(), indices=None, primitive="points")
    plain = replace(draw.draw, mesh=dots, instances=instances, vertex_array=True, state=State())
    points = replace(draw, draw=plain)
    got = capture(points, text, parts, bindings, mesh.vertices * instances)
    return Samples(
        inputs=mesh_inputs(mesh, instances), outputs={p.name + p.path: v for p, v in got.items()}
    )


def _capture_emitted(
    draw: PreparedDraw, bindings: Bindings, mesh: Mesh, given: Samples, capture: CaptureOutputs
) -> Samples:
    texts = {
        "vertex": stages.pass_instance_on(draw.text("vertex")),
        "geometry": stages.count_emitted(draw.text("geometry")),
    }
    counters = [VaryingPart(name, "", "int") for name in stages.EMITTED.values()]
    parts = vertex_parts(draw.text("geometry"), draw.interface)
    plain = replace(draw, draw=replace(draw.draw, vertex_array=True, state=State()))
    got = dict(capture(plain, texts, [*parts, *counters], bindings, None))
    source = {
        name: got.pop(counter) for name, counter in zip(stages.EMITTED, counters, strict=True)
    }
    which = primitive_corners(mesh)[source["gl_PrimitiveIDIn"][:, 0]]
    first = source["gl_InstanceID"] * mesh.vertices
    vertex = vertex_parts(draw.text("vertex"), draw.vertex_interface)
    outputs = {piece: given.outputs[piece.name + piece.path] for piece in vertex}
    inputs: dict[str, Array] = dict(source)
    for name, values in join_parts(outputs).items():
        for corner in range(which.shape[1]):
            inputs[_corner_name(name, corner)] = values[(first + which)[:, corner]]
    made = {piece.name + piece.path: values for piece, values in got.items()}
    return Samples(inputs=inputs, outputs=made, entering=_rename_entering(given))


def _capture_tessellated(
    draw: PreparedDraw, bindings: Bindings, mesh: Mesh, given: Samples, capture: CaptureOutputs
) -> Samples:
    text = draw.text("tess_evaluation")
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
    """Name what a vertex stage gave as a geometry stage names it."""
    return replace(given, outputs={entering_name(n): v for n, v in given.outputs.items()})


def _corner_name(name: str, corner: int) -> str:
    """Name a vertex stage's output as a geometry shader does for one vertex of its primitive."""
    if name.startswith("gl_"):
        return f"gl_in[{corner}].{name}"
    return re.sub(r"^\w+", rf"\g<0>[{corner}]", name)
