"""The courtyard drawn twice: from the light into a shadow map, and from the camera with it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab import (
    Cell,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    State,
    Target,
    exact,
    formula,
    measure,
    value,
)
from shaderlab.model.expectation import Expectation
from shaderlab.model.scene import UniformValue
from shaderlab.model.textures import TextureSource
from shaderlab.reference.transforms import look_at, orthographic

from .cameras import turned
from .courtyard import boxes, courtyard
from .courtyard_light import light_position, stored_depth
from .draws import tested, twins
from .figures import figure
from .lit import BELOW, GRAZING, TURNED_AWAY, picture, picture_check
from .shadow_truth import hidden_share, told_otherwise

Matrix = npt.NDArray[Any]
SUN = (-2.0, 4.0, -1.0)
EYE = (1.9, 3.3, -4.9)
PICTURED = {"FragColor": "rgba16f", "place": "rgba32f"}
"""What a large picture keeps: its light, and what rays need to check it."""
SHADOW = {"shadow": "r32f"}
"""What a pass keeps whose surfaces another one has already."""
MODEL = turned(6.0)
BOXES = [MODEL @ box for box in boxes()]
LIGHT_VIEW = look_at(SUN, (0.0, 0.0, 0.0))
LIGHT_SPACE = orthographic(-6.0, 6.0, -6.0, 6.0, 1.0, 9.0) @ LIGHT_VIEW
WHITE = {"wrap": ("clamp_to_border",) * 2, "border": (1.0, 1.0, 1.0, 1.0)}
"""A border of light around the map."""


def cast(
    name: str, light_space: Matrix, model: Matrix, size: int = 1024, *, solid: Any = None
) -> Pass:
    """A shadow map: the depths nearest to the light, in the depth attachment.

    Args:
        name: of the pass.
        light_space: the matrix of the light's view and projection.
        model: of the whole scene.
        size: texels along each side.
        solid: what throws shadows; the courtyard by default.

    >>> cast("shadow", np.eye(4), np.eye(4), size=64).target.size
    (64, 64)
    """
    uniforms = {"model": model, "lightSpaceMatrix": light_space}
    shader = "ch05_lighting/shadow_depth"
    draw = tested(shader, courtyard() if solid is None else solid, uniforms, only=("aPos",))
    return Pass(name=name, target=Target(size=(size, size), depth="depth32f"), draws=(draw,))


def lit(
    name: str,
    shadow_map: TextureSource,
    light_space: Matrix,
    model: Matrix,
    camera: tuple[Matrix, Matrix],
    uniforms: Mapping[str, UniformValue] | None = None,
    **target: Any,
) -> Pass:
    """The courtyard in the sun, its shadows from a map.

    Args:
        name: of the pass.
        shadow_map: what `cast` gave.
        light_space: the matrix that it was drawn with.
        model: of the whole courtyard.
        camera: view and projection.
        uniforms: others than no bias and a single texel.
        target: what `Target` takes.

    >>> from shaderlab.model.textures import Output
    >>> map = Output("shadow.depth")
    >>> lit("lit", map, *[np.eye(4)] * 2, (np.eye(4), np.eye(4))).draws[0].uniforms["radius"]
    0
    """
    view, projection = camera
    draw = Draw(
        vertex="ch05_lighting/shadow_map.vert",
        fragment="ch05_lighting/shadow_map.frag",
        mesh=Mesh(**courtyard()),
        uniforms={
            "model": model,
            # Half as long as they were: the fragment shader is to make them whole again.
            "normalMatrix": 0.5 * np.linalg.inv(model[:3, :3]).T,
            "view": view,
            "projection": projection,
            "lightSpaceMatrix": light_space,
            "lightPos": SUN,
            "viewPos": EYE,
            "leastBias": 0.0,
            "mostBias": 0.0,
            "radius": 0,
            **(uniforms or {}),
        },
        textures={"shadowMap": shadow_map},
        state=State(depth=Depth()),
    )
    return Pass(name=name, target=Target(depth="depth24", **target), draws=(draw,))


def single_points(name: str) -> list[Expectation]:
    """What a pass of `lit` must give where none of its pixels lies: just before the light's far
    plane, on a surface that looks away from sun and eye, on one that looks away from the sun,
    between a sun and an eye that are both hardly above it, and seen from behind.

    >>> [e.name for e in single_points("judged")]
    ['just before the far plane it is dark', 'what looks away has ambient light alone', \
'no highlight on a face turned away', 'a highlight of a sun that just rises', \
'seen from behind there is none']
    """
    point = {"FragPos": (0.0, 0.0, 0.0), "Color": (0.5, 0.5, 0.5)}
    before, past = ((0.0, 0.0, depth, 1.0) for depth in (0.99, 1.01))
    upward = {**point, "Normal": (0.0, 2.0, 0.0), "FragPosLightSpace": past}
    return [
        value(
            f"{name}.shadow",
            at={**point, "Normal": (0.0, 1.0, 0.0), "FragPosLightSpace": before},
            equals=1.0,
            digits=6,
            name="just before the far plane it is dark",
        ),
        value(
            f"{name}.FragColor",
            at={**point, "Normal": (0.0, -3.0, 0.0), "FragPosLightSpace": past},
            equals=(0.075, 0.075, 0.075, 1.0),
            digits=6,
            name="what looks away has ambient light alone",
        ),
        value(
            f"{name}.FragColor",
            at={**point, **GRAZING, "lightPos": BELOW, "FragPosLightSpace": past},
            equals=(0.075, 0.075, 0.075, 1.0),
            digits=6,
            name=TURNED_AWAY,
        ),
        value(
            f"{name}.FragColor",
            at={**upward, "lightPos": (-2.0, 0.01, 0.0), "viewPos": (2.0, 0.01, 0.0)},
            equals=(0.1775, 0.1775, 0.1775, 1.0),
            digits=6,
            name="a highlight of a sun that just rises",
        ),
        value(
            f"{name}.FragColor",
            at={**upward, "lightPos": SUN, "viewPos": (0.0, -5.0, 0.0)},
            equals=(0.511436, 0.511436, 0.511436, 1.0),
            digits=6,
            name="seen from behind there is none",
        ),
    ]


def past_far_plane(name: str) -> Any:
    """Past the light's far plane nothing is dark."""
    at = {
        "FragPosLightSpace": (0.0, 0.0, 1.01, 1.0),
        "FragPos": (0.0, 0.0, 0.0),
        "Normal": (0.0, 1.0, 0.0),
        "Color": (1.0, 1.0, 1.0),
    }
    return figure(f"{name}.shadow", "past the far plane nothing is dark", at, 0.0)


EQUAL_SHARE = 2.0 / 256.0
"""The share of places that a map without a bias may tell otherwise than by rays.

There the depths that are compared are those of one plane, at the place and in its texel's middle.
Where depth grows by a and b over a texel, they differ by a u + b v with u and v even in ±½. That
is within d of 0 for at most 2 d / max(a, b) of all places. If a driver moves corners to its grid
(OpenGL 4.6, 14.6.1, leaves it 4 bits, and most have 8), by half a step each way, planes move as
far: d = (a + b) / 512. So there are at most 4/512.
"""


def map_of_rays_check(
    name: str = "", *, light_space: Matrix = LIGHT_SPACE, radius: int = 0, **measured: Any
) -> Any:
    """The shadow map of the sun tells of next to no place something else than a map that rays make:
    the same texels, the same bias, nothing rasterised.

    Corners are moved by up to 1/256 of a texel, and depths are rounded to 2⁻²⁴: only places within
    that of an edge or of equality may differ, a few of 10,000, for each texel that is asked. More
    are near equality where there is no bias; see `EQUAL_SHARE`.

    Args:
        name: what else is to be said of the map.
        light_space: the matrix that the map was drawn with.
        radius: texels that are asked, to either side.
        measured: as `measure` takes them: `reads` (shadow, place, upright) and `given` (the map's
            size, its biases), or `readings` of these.

    >>> map_of_rays_check("9 texels: ", reads={}).name
    '9 texels: told otherwise than by a map of rays'
    """
    return measure(
        f"{name}told otherwise than by a map of rays",
        told_otherwise(light_space, SUN, BOXES, radius),
        at_most=0.001 * (2 * radius + 1) ** 2,
        **measured,
    )


def in_cell(description: Pass, cell: Cell) -> Draw:
    """The only draw of a pass, in one cell of the picture."""
    (draw,) = description.draws
    return replace(draw, state=replace(draw.state, cell=cell))


def photographed(draws: Iterable[Draw], **target: Any) -> tuple[Pass, ...]:
    """Passes "scene" for people, with the places that rays need to check it, and "picture"; and
    "scene-backwards", the triangles of each draw from last to first."""
    target = {"size": (1024, 1024), "colors": PICTURED, "depth": "depth24", **target}
    half = (target["size"][0] // 2,) * 2 if target["size"] != (1024, 1024) else None
    scene = Pass(name="scene", target=Target(**target), draws=tuple(draws))
    twin, _ = twins(scene)
    draws = tuple(twins(replace(scene, draws=(draw,)))[0].draws[0] for draw in scene.draws)
    return replace(twin, draws=draws), scene, *picture(size=half)


def picture_checks(
    eye: Any, models: Any, *, drawn: float = 0.99, hidden: float = 0.002
) -> tuple[Any, ...]:
    """The large picture is drawn, the nearest surfaces in front, and encoded for a display.

    Args:
        eye: the camera's place.
        models: the boxes' matrices, from the unit box around the origin.
        drawn: the least share of it that shows anything but the background.
        hidden: the largest share of places in it that a box hides from the eye; of every eighth
            pixel, both ways.

    >>> [check.name for check in picture_checks((0.0, 0.0, 2.0), [])][:2]
    ['the picture', 'pixels of the large picture that the order of drawing changes']
    """
    return (
        picture_check(),
        measure(
            "pixels of the large picture that the order of drawing changes",
            _changed_share,
            reads=reads("scene", "FragColor", backwards="scene-backwards.FragColor"),
            at_most=1e-5,  # ten pixels of a million
            own_types=True,
            note="where two faces meet, they are equally near",
        ),
        measure(
            "share of the large picture that is drawn",
            _drawn_share,
            reads=reads("scene", "FragColor"),
            at_least=drawn,
            own_types=True,
        ),
        measure(
            "places hidden from the eye, in the large picture",
            hidden_share(eye, models, step=8),
            reads=reads("scene", "FragColor", "place"),
            at_most=hidden,
            own_types=True,
        ),
    )


def surface_checks(eye: Any, models: Any, name: str, others: Iterable[str] = ()) -> list[Any]:
    """Next to no place of a pass is hidden from the eye by a box, and other passes that look from
    the same place see the same surfaces.

    >>> [check.name for check in surface_checks((0.0, 0.0, 2.0), [], "one", ["two"])]
    ['places hidden from the eye', 'two: the same surfaces']
    """
    hidden = measure(
        "places hidden from the eye",
        hidden_share(eye, models, step=1),
        reads=reads(name, "FragColor", "place"),
        at_most=0.002,
        own_types=True,
    )
    return [hidden, *(same_surfaces(other, name) for other in others)]


def same_surfaces(one: str, other: str) -> Any:
    """Two passes from the same place have the same depths, bit for bit."""
    depth, name = Output(f"{other}.depth"), f"{one}: the same surfaces"
    return exact(f"{one}.depth", depth, name=name, pictured=False)


def reads(name: str, *outputs: str, **of_others: str) -> dict[str, str]:
    """Outputs of one pass by their own names, and outputs of others as they are given.

    >>> reads("judged", "place", shadow="large.shadow")
    {'place': 'judged.place', 'shadow': 'large.shadow'}
    """
    return {**{output: f"{name}.{output}" for output in outputs}, **of_others}


def faces(upright: Matrix, to_light: Any) -> npt.NDArray[np.bool_]:
    """The places that face the light, of normals that are 0 where nothing is drawn."""
    facing: npt.NDArray[np.bool_] = (upright * to_light).sum(axis=-1) > 0.0
    return facing


def _changed_share(FragColor: Matrix, backwards: Matrix) -> float:
    return float((FragColor != backwards).any(axis=-1).mean())


def _drawn_share(FragColor: Matrix) -> float:
    return float((FragColor[..., 3] > 0.0).mean())


def map_checks(name: str) -> list[Any]:
    """A shadow map holds the depths that the light sees.

    >>> [check.output for check in map_checks("shadow")]
    ['shadow.gl_Position', 'shadow.depth']
    """
    return [formula(f"{name}.gl_Position", light_position), formula(f"{name}.depth", stored_depth)]
