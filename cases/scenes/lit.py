"""Lit scenes: things before a camera, drawn large for people and small for the checks.

All of them share the vertex shaders `lit`, `lit_painted` and `lit_textured` of chapter 5. The large
picture is drawn in light (half floats); `finish.frag` halves it and encodes it for a display.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy.typing as npt

from shaderlab import Cell, Draw, Output, Pass, Target, any_order, assets, formula, fullscreen
from shaderlab.glslmath import vec4
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.transforms import (
    clip_position,
    normal_matrix,
    translate,
    world_normal,
    world_position,
)

from .draws import tested, twins
from .laws import Law, unchanged
from .panels import panel_pass
from .studio import finished, handed_on

Matrix = npt.NDArray[Any]
Uniforms = Mapping[str, Any]
Vector = Sequence[float]
Color = tuple[float, float, float, float]

LIT = "ch05_lighting/lit.vert"
PAINTED = "ch05_lighting/lit_painted.vert"
TEXTURED = "ch05_lighting/lit_textured.vert"
PLACED = "ch07_maps/placed.vert"
BLACK = (0.0, 0.0, 0.0, 0.0)

# A test point: a surface in the origin that faces +z, the viewer before it, a lamp aside.
POINT = {"FragPos": (0.0, 0.0, 0.0), "Normal": (0.0, 0.0, 1.0), "viewPos": (0.0, 0.0, 3.0)}
POINT_LAMP = (1.2, 1.0, 2.0)
# From here the viewer is nearly 90° from the mirrored ray, where a lobe without its clamp shows.
ASIDE = (2.0, 0.0, 1.215)
# A lamp 5° below the horizon of that surface, and a viewer 10° above it on the other side: without
# its gate, a highlight shines through.
BELOW = (-math.cos(math.radians(5.0)), 0.0, -math.sin(math.radians(5.0)))
TOWARDS_BELOW = tuple(-x for x in BELOW)
GRAZING = {**POINT, "viewPos": (math.cos(math.radians(10.0)), 0.0, math.sin(math.radians(10.0)))}
TURNED_AWAY = "no highlight on a face turned away"
CORAL, HALF, WHITE = (1.0, 0.5, 0.31), (0.5, 0.5, 0.5), (1.0, 1.0, 1.0)
# Light at that point, and a coral surface.
POINT_LIGHT = {"light.ambient": (0.2, 0.2, 0.2), "light.diffuse": HALF, "light.specular": WHITE}
CORAL_POINT = {
    "FragPos": POINT["FragPos"],
    "Normal": POINT["Normal"],
    "Color": CORAL,
    "viewPos": POINT["viewPos"],
    "specular": HALF,
}

_VERTEX_STAGE: Mapping[str, Law] = {
    "gl_Position": clip_position,
    "FragPos": world_position,
    "Normal": world_normal,
    "Color": handed_on,
    "TexCoords": unchanged("aTexCoords"),
}


def thing(
    fragment: str,
    solid: Any,
    model: Matrix,
    camera: Uniforms,
    uniforms: Uniforms,
    *,
    vertex: str = LIT,
    textures: Mapping[str, Any] | None = None,
    cell: Cell | None = None,
    **state: Any,
) -> Draw:
    """One thing of the scene, depth tested.

    Args:
        fragment: the shader that lights it.
        solid: a mesh, or a geometry of `shaderlab.assets`.
        model: where it stands; its normals go through the inverse transpose.
        camera: what `camera` gave.
        uniforms: what else the shaders want.
        vertex: LIT or PLACED (places and normals), PAINTED (a colour as well) or TEXTURED.
        textures: by sampler.
        cell: the part of the target to draw into.
        state: what else `State` takes.
    """
    # Half of it, which gives the same directions: no part of the model matrix is that.
    placed = {"model": model, "normalMatrix": 0.5 * normal_matrix(model)}
    return tested(
        (vertex, fragment),
        solid,
        {**placed, **camera, **uniforms},
        only=("aPos", "aNormal") if vertex in (LIT, PLACED) else (),
        textures=textures,
        cell=cell,
        **state,
    )


def bulb(place: Vector, glow: Vector, radius: float, camera: Uniforms) -> Draw:
    """A lamp itself: a small ball that is not lit, but shines."""
    uniforms = {"model": translate(place), **camera, "glow": glow}
    return tested("ch05_lighting/lamp", assets.sphere(radius), uniforms, only=("aPos",))


def glowing(glow: Any) -> Any:
    """A lamp's own light, as a bulb shows it."""
    return vec4(glow, 1.0)


def glow(color: Vector) -> Pass:
    """A pass that a bulb's light fills: a bulb itself has few pixels where it is judged.

    >>> glow((1.0, 0.9, 0.8)).target.size
    (16, 16)
    """
    return panel_pass("glow", "ch05_lighting/lamp.frag", {}, {"glow": color}, size=(16, 16))


def glow_check() -> Any:
    """Each pixel of `glow`.

    >>> glow_check().output
    'glow.FragColor'
    """
    return formula("glow.FragColor", glowing, name="a lamp's light at each pixel")


def photographed(
    draws: Sequence[Draw],
    judged: Sequence[Draw] | None = None,
    *,
    clear: Color = BLACK,
    output: str = "FragColor",
    name: str = "judged",
    size: tuple[int, int] | None = None,
    side: int = 1024,
) -> tuple[Pass, ...]:
    """Passes "scene" and "picture" for people, and one for the checks; both scenes as `twins`.

    Args:
        draws: of the large scene.
        judged: of the small one, if they are others.
        clear: the background of both.
        output: what the picture shows.
        name: of the pass that is judged.
        size: of that pass; a case's own by default.
        side: of the large scene; the picture has half of it, if that is not 1024.
    """
    large = large_scene(draws, clear=clear, output=output, side=side)
    half = None if side == 1024 else (side // 2, side // 2)
    target = Target(size=size, depth="depth24", clear=large.target.clear)
    return (
        *twins(large, output),
        *picture(output=output, size=half),
        *twins(Pass(name=name, target=target, draws=tuple(judged or draws)), output),
    )


def large_scene(
    draws: Sequence[Draw], *, clear: Color = BLACK, output: str = "FragColor", side: int = 1024
) -> Pass:
    """The pass "scene" for people, in light."""
    target = Target(size=(side, side), colors={output: "rgba16f"}, depth="depth24", clear=clear)
    return Pass(name="scene", target=target, draws=tuple(draws))


def picture(
    of: str = "scene",
    *,
    output: str = "FragColor",
    name: str = "picture",
    size: tuple[int, int] | None = None,
) -> tuple[Pass, ...]:
    """A scene's light, each pixel the mean of four texels, encoded for a display."""
    return fullscreen(
        "ch05_lighting/finish.frag",
        name=name,
        textures={"scene": Output(f"{of}.{output}")},
        target=Target(size=size),
    )


def picture_checks(output: str = "FragColor", *, judged: str = "judged") -> tuple[Any, ...]:
    """The picture is the scene's light, encoded; and neither scene depends on the order of draws.

    >>> [check.name for check in picture_checks()][0]
    'the picture'
    """
    return (picture_check(), any_order(f"scene.{output}"), any_order(f"{judged}.{output}"))


def picture_check() -> Any:
    """The picture is the scene's light, encoded for a display."""
    return formula("picture.FragColor", finished(texture), name="the picture")


def vertex_stage_checks(*outputs: str, pass_name: str = "", draw: int = -1) -> tuple[Any, ...]:
    """What the vertex shaders of lit scenes give: places in clip space and in the world, normals,
    and what is handed on.

    Args:
        outputs: of gl_Position, FragPos, Normal, Color and TexCoords; the first three by default.
        pass_name: the pass that is judged, if it is not the last.
        draw: which of its draws.

    >>> [check.output for check in vertex_stage_checks(pass_name="judged")]
    ['judged.gl_Position', 'judged.FragPos', 'judged.Normal']
    """
    prefix = f"{pass_name}." if pass_name else ""
    return tuple(
        formula(prefix + output, _VERTEX_STAGE[output], draw=draw)
        for output in outputs or ("gl_Position", "FragPos", "Normal")
    )
