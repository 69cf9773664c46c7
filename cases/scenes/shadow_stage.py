"""The courtyard drawn twice: from the light into a shadow map, and from the camera with it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab import Cell, Depth, Draw, Mesh, Pass, State, Target, formula, measure, reading, value
from shaderlab.model import Expectation, TextureSource, UniformValue
from shaderlab.reference.transforms import look_at, orthographic

from .cameras import turned
from .courtyard import boxes, courtyard
from .courtyard_light import light_position, stored_depth
from .draws import tested
from .figures import figure
from .shadow_truth import hidden_share

Matrix = npt.NDArray[Any]
SUN = (-2.0, 4.0, -1.0)
EYE = (1.9, 3.3, -4.9)
PICTURED = {"FragColor": "rgba16f", "shadow": "r8", "place": "rgba32f", "upright": "rgba16f"}
"""What a large picture keeps of its light and of what rays need to check its shadows."""
PLACES = ("FragColor", "shadow", "place", "upright")
"""The outputs that statistics about shadows read."""
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

    >>> from shaderlab.model import Output
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
    plane, and on a surface that looks away from sun and eye.

    >>> [e.name for e in single_points("judged")]
    ['just before the far plane it is dark', 'what looks away has ambient light alone']
    """
    point = {"FragPos": (0.0, 0.0, 0.0), "Color": (0.5, 0.5, 0.5)}
    before, past = ((0.0, 0.0, depth, 1.0) for depth in (0.99, 1.01))
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


def in_cell(description: Pass, cell: Cell) -> Draw:
    """The only draw of a pass, in one cell of the picture."""
    (draw,) = description.draws
    return replace(draw, state=replace(draw.state, cell=cell))


def large(draws: Iterable[Draw], **target: Any) -> Pass:
    """The pass "scene" for people, with what rays need to check it."""
    target = {"size": (1024, 1024), "colors": PICTURED, "depth": "depth24", **target}
    return Pass(name="scene", target=Target(**target), draws=tuple(draws))


def reads(name: str, *outputs: str) -> dict[str, str]:
    """Outputs of one pass by their own names, those of PLACES unless others are given.

    >>> reads("judged", "place")
    {'place': 'judged.place'}
    """
    return {output: f"{name}.{output}" for output in outputs or PLACES}


def hidden(eye: Any, models: Any, names: Iterable[str]) -> Any:
    """A depth test that works leaves next to no place that a box hides from the eye."""
    return measure(
        "places hidden from the eye",
        hidden_share(eye, models, step=1),
        readings=[reading(name, reads=reads(name, "FragColor", "place")) for name in names],
        at_most=0.002,
    )


def hidden_in_picture(eye: Any, models: Any, name: str = "scene", *, at_most: float = 0.002) -> Any:
    """The same of every eighth pixel of the large picture, both ways."""
    return measure(
        "places hidden from the eye, in the large picture",
        hidden_share(eye, models, step=8),
        reads=reads(name, "FragColor", "place"),
        at_most=at_most,
    )


def drawn(at_least: float) -> Any:
    """How much of the large picture shows anything but the background."""
    return measure(
        "share of the large picture that is drawn",
        _drawn_share,
        reads={"FragColor": "scene.FragColor"},
        at_least=at_least,
    )


def faces(FragColor: Matrix, upright: Matrix, to_light: Any) -> npt.NDArray[np.bool_]:
    """The places that are drawn and face the light."""
    facing: npt.NDArray[np.bool_] = (upright * to_light).sum(axis=-1) > 0.0
    return (FragColor[..., 3] > 0.0) & facing


def _drawn_share(FragColor: Matrix) -> float:
    return float((FragColor[..., 3] > 0.0).mean())


def map_checks(name: str) -> list[Any]:
    """A shadow map holds the depths that the light sees.

    >>> [check.output for check in map_checks("shadow")]
    ['shadow.gl_Position', 'shadow.depth']
    """
    return [
        formula(f"{name}.gl_Position", light_position),
        formula(f"{name}.depth", stored_depth),
    ]
