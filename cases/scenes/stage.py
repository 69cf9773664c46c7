"""Scenes of painted solids, ready to draw: a prop on the stage, and its picture with smooth edges.

A picture is drawn twice as large as it is shown, then four texels become one pixel: that needs no
multisampling, which not every driver has. The same draws go, small, into the pass "judged".
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
    formula,
    fullscreen,
    value,
)
from shaderlab.assets.meshes import Geometry
from shaderlab.assets.order import both_ways
from shaderlab.model import Expectation, UniformValue

Matrix = npt.NDArray[Any]
SKY = (0.80, 0.83, 0.86, 1.0)
# No symmetry, so that a product the wrong way round shows.
SHEAR = np.array([[1.0, 2.0, 2.0, 1.0], [0.0, 1.0, 2.0, 3.0], [2.0, 0.0, 1.0, 1.0], [1, 0, 0, 1]])


def prop(
    solid: Geometry,
    view: Matrix,
    projection: Matrix,
    *,
    model: Matrix | None = None,
    cell: Cell | None = None,
    depth: str = "less",
) -> Draw:
    """A painted solid that a plain model–view–projection chain puts on the stage.

    >>> prop({"attributes": {"aPos": np.zeros((3, 3))}, "indices": np.arange(3)},
    ...      np.eye(4), np.eye(4)).uniforms["normalMatrix"].diagonal().tolist()
    [1.0, 1.0, 1.0]
    """
    model = np.eye(4) if model is None else np.asarray(model, float)
    uniforms: dict[str, UniformValue] = {
        "model": model,
        "normalMatrix": np.linalg.inv(model[:3, :3]).T,
        "view": view,
        "projection": projection,
    }
    return Draw(
        vertex="ch03_transforms/studio.vert",
        fragment="ch03_transforms/studio.frag",
        mesh=Mesh(**solid),
        uniforms=uniforms,
        state=State(depth=Depth(func=depth), cell=cell),
    )


def prop_checks(
    position: Callable[..., Any],
    normal: Callable[..., Any],
    color: Callable[..., Any],
    light: Callable[..., Any],
    *,
    draw: int = 0,
    pass_name: str = "judged",
) -> tuple[Expectation, ...]:
    """What must hold of a prop: its vertices and pixels, and one colour under a long normal.

    >>> [check.name for check in prop_checks(abs, abs, abs, abs)][0]
    'a prop in clip space'
    """
    return (
        formula(f"{pass_name}.gl_Position", position, draw=draw, name="a prop in clip space"),
        value(
            f"{pass_name}.gl_Position",
            at={"aPos": (1.0, 2.0, 3.0), "model": SHEAR, "view": np.eye(4), "projection": SHEAR},
            equals=(48.0, 29.0, 32.0, 14.0),
            digits=6,
            reference=position,
            draw=draw,
            name="matrices before columns",
        ),
        formula(f"{pass_name}.Normal", normal, draw=draw, name="a prop's normals"),
        value(
            f"{pass_name}.Normal",
            at={"aNormal": (1.0, 2.0, 3.0), "normalMatrix": SHEAR[:3, :3]},
            equals=(11.0, 8.0, 5.0),
            digits=6,
            reference=normal,
            draw=draw,
            name="a normal by the matrix given",
        ),
        formula(f"{pass_name}.Color", color, draw=draw, name="a prop's colours"),
        formula(f"{pass_name}.FragColor", light, draw=draw, name="a prop in the light"),
        *light_checks(light, draw=draw, pass_name=pass_name),
    )


def light_checks(
    light: Callable[..., Any], *, draw: int = -1, pass_name: str = "judged"
) -> tuple[Expectation, ...]:
    """The studio's light on surfaces that a scene may lack: turned away, black, too bright.

    >>> [check.name for check in light_checks(abs)][0]
    'grey, facing up'
    """
    grey, green, up = (0.5, 0.5, 0.5), (0.2, 0.4, 0.6), (0.0, 2.0, 0.0)
    return tuple(
        value(
            f"{pass_name}.FragColor",
            at={"Color": color, "Normal": normal},
            equals=(*equals, 1.0),
            digits=6,
            reference=light,
            draw=draw,
            name=name,
        )
        for name, color, normal, equals in (
            ("grey, facing up", grey, up, (0.742866, 0.742866, 0.742866)),
            ("towards the lamp", green, (-2.0, 1.0, 2.0), (0.471116, 0.645595, 0.776250)),
            ("away from the lamp", green, (2.0, -1.0, -2.0), (0.317252, 0.434747, 0.522730)),
            ("black, as dark as it gets", (0.0, 0.0, 0.0), up, (0.001874, 0.001874, 0.001874)),
            ("brighter than white", (4.0, 4.0, 4.0), up, (1.0, 1.0, 1.0)),
        )
    )


def photographed(
    draws: Sequence[Draw],
    size: tuple[int, int],
    clear: tuple[float, float, float, float] = SKY,
    depth: str = "depth24",
) -> tuple[Pass, ...]:
    """Passes "scene" and "picture" for people, and "soft" and "judged" (`both_ways`) for checks.

    Args:
        draws: the same for all of them.
        size: of the picture in pixels; at least 256 each way, or it is shown enlarged.
        clear: the background.
        depth: format of the depth buffer, "depth24_stencil8" where the draws test the stencil.
    """
    width, height = size
    small = (96, 2 * round(48 * height / width))

    def drawn(name: str, size: tuple[int, int]) -> Pass:
        return Pass(
            name=name, target=Target(size=size, depth=depth, clear=clear), draws=tuple(draws)
        )

    def half(name: str, of: str, size: tuple[int, int]) -> tuple[Pass, ...]:
        return fullscreen(
            "ch03_transforms/soften.frag",
            name=name,
            domain={},
            textures={"scene": Output(of, "FragColor")},
            target=Target(size=size),
        )

    return (
        drawn("scene", (2 * width, 2 * height)),
        *half("picture", "scene", size),
        *both_ways(drawn("judged", small)),
        *half("soft", "judged", (small[0] // 2, small[1] // 2)),
    )
