"""Realistic mistakes about buffers, framebuffers and geometry shaders: each makes its case fail."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from shaderlab import UniformBuffer
from shaderlab.model.case import Case
from shaderlab.model.mesh import Mesh
from shaderlab.model.scene import Draw, Pass
from tests.catalogue import shipped
from tests.negative.broken import failing, failures, first_failure, mistaken, with_draws

CH2, CH8, CH10 = "ch02_basics", "ch08_techniques", "ch10_buffers"
ROSETTE = f"{CH10}/rosette"

# case, shader, what stands there, the mistake
SHADERS = [
    # attributes taken for one another, or not handed on
    ("interleaved-attributes", f"{CH2}/interleaved_attributes.vert", "ourColor = aColor",
     "ourColor = aPos"),
    ("interleaved-attributes", f"{CH2}/interleaved_attributes.vert", "TexCoord = aTexCoord",
     "TexCoord = aTexCoord.ts"),
    ("interleaved-attributes", f"{CH2}/interleaved_attributes.frag", "8.0 * TexCoord",
     "4.0 * TexCoord"),
    ("vertex-array", f"{CH2}/vertex_array.vert", "aPos.y + 0.5", "aPos.y"),
    ("vertex-array", f"{CH2}/vertex_array.frag", "0.30), height", "0.30), 1.0 - height"),
    ("buffer-subdata", f"{ROSETTE}.vert", "ourColor = aColor", "ourColor = aPos"),
    ("buffer-map", f"{ROSETTE}.frag", "sqrt(ourColor)", "ourColor"),
    ("buffer-usage", f"{ROSETTE}.vert", "aPos, 1.0", "aPos, 1.1"),
    ("batched-attributes", f"{ROSETTE}.frag", "sqrt(ourColor)", "sqrt(ourColor.bgr)"),
    ("points-and-elements", f"{CH10}/points.vert", "gl_PointSize = size", "gl_PointSize = 1.0"),
    ("points-and-elements", f"{CH10}/points.vert", "ourColor = aColor", "ourColor = aColor.gbr"),
    ("mesh-class", f"{CH10}/mesh_class.vert", "size * aPos.xy + offset",
     "size * (aPos.xy + offset)"),
    ("mesh-class", f"{CH10}/mesh_class.vert", "ourColor = aColor", "ourColor = size * aColor"),
    # a kernel's rows upside down, neighbours half a texel away, the wrong divisor
    ("post-kernels", f"{CH8}/post_kernels.frag", "1 - row", "row - 1"),
    ("post-kernels", f"{CH8}/post_kernels.frag", "1.0 / vec2(", "0.5 / vec2("),
    ("post-kernels", f"{CH8}/post_kernels.frag", "3 * row + column", "3 * column + row"),
    ("post-grayscale", f"{CH8}/post_grayscale.frag", "/ 3.0", "/ 3.1"),
    ("post-grayscale", f"{CH8}/post_grayscale.frag", "0.2126, 0.7152, 0.0722",
     "0.299, 0.587, 0.114"),
    ("post-grayscale", f"{CH8}/post_grayscale.frag", "dot(decoded(color), weights)",
     "dot(color, weights)"),
    ("post-inversion", f"{CH8}/post_inversion.frag", "1.0 - texture", "0.99 - texture"),
    ("post-inversion", f"{CH8}/post_inversion.frag", "vec4(1.0 - texture(screenTexture, "
     "TexCoords).rgb, 1.0)", "1.0 - texture(screenTexture, TexCoords)"),
    ("face-culling", f"{CH8}/face_culling.vert", "-aPos.x : aPos.x", "aPos.x : aPos.x"),
    ("face-culling", f"{CH8}/face_culling.frag", "gl_FrontFacing ?", "!gl_FrontFacing ?"),
    ("framebuffer-texture", f"{CH8}/framebuffer_texture.vert", "= aTexCoords",
     "= vec2(aTexCoords.x, 1.0 - aTexCoords.y)"),
    ("framebuffer-texture", f"{CH8}/copy.frag", "texture(screen, TexCoords)",
     "texture(screen, 1.0 - TexCoords)"),
    ("framebuffer-renderbuffer", f"{CH8}/framebuffer_renderbuffer.vert", "aPos.xy, depth",
     "aPos.xy, -depth"),
    ("framebuffer-renderbuffer", f"{CH8}/framebuffer_renderbuffer.frag", "= color",
     "= vec4(color.rgb, 0.5)"),
    ("multiple-render-targets", f"{CH8}/multiple_render_targets.frag", "0.5 * n + 0.5",
     "0.5 * n"),
    ("multiple-render-targets", f"{CH8}/multiple_render_targets.frag", "Luminance > 0.4",
     "Luminance > 0.5"),
    ("uniform-buffer", f"{CH8}/uniform_buffer.vert", "projection * (view *",
     "view * (projection *"),
    ("uniform-buffer", "lib/block_light.glsl", "lights.gains[2]", "lights.gains[1]"),
    ("batching", f"{CH8}/batching_instanced.vert", "aPos + aOffset", "aPos - aOffset"),
    ("batching", f"{CH8}/batching_merged.vert", "Color = aColor", "Color = aColor.grb"),
    ("geometry-houses", f"{CH8}/geometry_houses.vert", "wall = aColor", "wall = 0.5 * aColor"),
    ("geometry-explode", f"{CH8}/geometry_explode.vert", "vec4(vs_out.world, 1.0)",
     "vec4(vs_out.world, 0.99)"),
    ("geometry-houses", f"{CH8}/geometry_houses.geom", "vec2(0.0, 2.0)", "vec2(0.0, 1.5)"),
    ("geometry-houses", f"{CH8}/geometry_houses_outline.geom", "corner(vec2(0.0, 2.0));", ""),
    ("geometry-explode", f"{CH8}/geometry_explode.geom", "cross(a, b)", "cross(b, a)"),
    ("geometry-explode", f"{CH8}/geometry_explode.geom", "sin(time) + 1.0", "sin(time)"),
    ("geometry-normals", f"{CH8}/geometry_normals.vert", "normalMatrix * aNormal", "aNormal"),
    ("geometry-normals", f"{CH8}/geometry_normals.geom", "projection * (gl_in[i].gl_Position + "
     "offset)", "projection * gl_in[i].gl_Position + offset"),
    ("reduced-resolution", f"{CH8}/copy.frag", "TexCoords)", "TexCoords + 0.002)"),
    ("reduced-resolution", f"{CH8}/reduced_resolution.frag", "place < 3.0", "place < 2.5"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("case_id", "shader", "right", "wrong"),
    SHADERS,
    ids=[f"{case}-{wrong[:40]}" for case, _, _, wrong in SHADERS],
)
def test_a_mistake_makes_its_case_fail(case_id: str, shader: str, right: str, wrong: str) -> None:
    assert first_failure(shipped()[case_id], mistaken(shader, right, wrong))


def with_mesh(case: Case, *, only: str = "", **memory: Any) -> Case:
    """The case with its meshes lying otherwise in memory, in one pass or in all."""

    def change(description: Pass, draw: Draw) -> Draw:
        if not isinstance(draw.mesh, Mesh) or only not in ("", description.name):
            return draw
        return replace(draw, mesh=replace(draw.mesh, **memory))

    return with_draws(case, change)


def failed(case: Case) -> set[str]:
    return failing(next(case.scenes()))


@pytest.mark.parametrize(
    ("case_id", "layout", "names"),
    [
        ("interleaved-attributes", "batched", {"stride 32, offsets 0, 12, 24"}),
        (
            "buffer-subdata",
            "interleaved",
            {"positions at 0, colours at 84", "two pieces", "the second one at byte 84"},
        ),
        ("buffer-map", "separate", {"positions, then colours", "mapped", "and unmapped"}),
        ("batched-attributes", "separate", {"batched: 111222", "interleaved: 123123"}),
        (
            "mesh-class",
            "batched",
            {"layout, first draw", "layout, last draw", "one vertex array for all"},
        ),
        ("batching", "separate", {"instanced: where attributes lie"}),
    ],
)
def test_another_layout_is_noticed_although_the_pixels_are_the_same(
    case_id: str, layout: str, names: set[str]
) -> None:
    assert failed(with_mesh(shipped()[case_id], layout=layout)) == names


def test_a_wrong_colour_in_the_buffer_is_noticed() -> None:
    case = shipped()["buffer-usage"]
    mesh = case.passes[-1].draws[0].mesh
    assert isinstance(mesh, Mesh)
    colors = {**mesh.attributes, "aColor": np.roll(mesh.attributes["aColor"], 1, axis=0)}
    assert failed(with_mesh(case, only=case.passes[-1].name, attributes=colors)) == {"DYNAMIC_COPY"}


def test_without_its_vertex_array_every_draw_is_an_error() -> None:
    case = with_draws(shipped()["vertex-array"], lambda _, d: replace(d, vertex_array=True))
    assert failed(case) == {"nothing bound: 0x0502", "nothing bound: nothing drawn"}


@pytest.mark.parametrize(
    "mistake",
    [
        lambda p, v: {"projection": v, "view": p.T},
        lambda p, v: {"projection": v, "view": p},
        lambda p, v: {"projection": p.T, "view": v},
        lambda p, v: {"projection": p, "view": v.T},
        lambda p, v: {"projection": p, "view": np.linalg.inv(v)},
    ],
    ids=["exchanged and transposed", "exchanged", "projection transposed", "view transposed",
         "the camera instead of its view"],
)  # fmt: skip
def test_plausible_wrong_matrices_in_the_buffer_are_noticed(
    mistake: Callable[[Any, Any], dict[str, Any]],
) -> None:
    case = shipped()["uniform-buffer"]
    matrices = case.passes[0].draws[0].blocks["Matrices"].values
    wrong = UniformBuffer(
        values=mistake(np.asarray(matrices["projection"]), np.asarray(matrices["view"]))
    )

    def change(_: Pass, draw: Draw) -> Draw:
        return replace(draw, blocks={**draw.blocks, "Matrices": wrong})

    # A formula judges each program by what the buffer holds; figures judge what that should be.
    figure = ["red: one step to the right"]
    assert not list(failures(next(case.scenes()), only=figure))
    assert list(failures(next(with_draws(case, change).scenes()), only=figure))


def test_culling_the_wrong_side_is_noticed() -> None:
    case = shipped()["face-culling"]

    def change(description: Pass, draw: Draw) -> Draw:
        state = draw.state
        if description.name == "cube, culled and tested":
            state = replace(state, cull="front")
        return replace(draw, state=state)

    assert "cube, culled and tested: its front" in failed(with_draws(case, change))


def test_more_draws_than_said_are_noticed() -> None:
    case = shipped()["batching"]
    twice = tuple(
        replace(p, draws=p.draws * 2) if p.name == "instanced 16" else p for p in case.passes
    )
    assert failed(replace(case, passes=twice)) == {"cost"}


def test_every_case_is_broken_at_least_twice() -> None:
    by_data = [
        "interleaved-attributes", "buffer-subdata", "buffer-map", "batched-attributes",
        "mesh-class", "batching", "buffer-usage", "vertex-array", "uniform-buffer",
        "face-culling",
    ]  # fmt: skip
    broken = [case_id for case_id, *_ in SHADERS] + by_data
    assert len(set(broken)) == 21
    assert min(broken.count(case_id) for case_id in broken) >= 2


def test_a_target_that_is_cleared_to_another_colour_is_seen() -> None:
    case = shipped()["geometry-houses"]
    street, *others = case.passes
    black = replace(street, target=replace(street.target, clear=(0.0, 0.0, 0.0, 1.0)))
    scene = replace(case, passes=(black, *others)).scene("default")
    assert list(failures(scene, only=["street: the sky"]))
