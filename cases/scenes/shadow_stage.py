"""The courtyard drawn twice: from the light into a shadow map, and from the camera with it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab import Depth, Draw, Mesh, Pass, State, Target, value
from shaderlab.model import Expectation, TextureSource, UniformValue

from .courtyard import courtyard

Matrix = npt.NDArray[Any]
SUN = (-2.0, 4.0, -1.0)
EYE = (1.9, 3.3, -4.9)
PICTURED = {"FragColor": "rgba16f", "shadow": "r8", "place": "rgba32f", "upright": "rgba16f"}
"""What a large picture keeps of its light and of what rays need to check its shadows."""


def cast(name: str, light_space: Matrix, model: Matrix, size: int = 1024) -> Pass:
    """A shadow map: the depths nearest to the light, in the depth attachment.

    >>> cast("shadow", np.eye(4), np.eye(4), size=64).target.size
    (64, 64)
    """
    draw = Draw(
        vertex="ch05_lighting/shadow_depth.vert",
        fragment="ch05_lighting/shadow_depth.frag",
        mesh=Mesh(**courtyard()).only("aPos"),
        uniforms={"model": model, "lightSpaceMatrix": light_space},
        state=State(depth=Depth()),
    )
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
    >>> map = Output("shadow", "depth")
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
