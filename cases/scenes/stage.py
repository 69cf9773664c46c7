"""Scenes of painted solids, ready to draw: a prop on the stage, and its picture with smooth edges.

A picture is drawn twice as large as it is shown, then four texels become one pixel: that needs no
multisampling, which not every driver has. The same draws go, small, into the pass "judged".
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab import Cell, Draw, Pass, Target, any_order, both_ways, formula
from shaderlab.assets.meshes import Geometry
from shaderlab.reference.transforms import clip_position, normal_matrix, world_normal

from .draws import tested
from .figures import each_draw, figure, figures
from .panel_checks import smaller_check, softened_check
from .panels import cell, softened_pass
from .studio import handed_on, studio_color

Matrix = npt.NDArray[Any]
Camera = Mapping[str, Any]
SKY = (0.80, 0.83, 0.86, 1.0)
# No symmetry, so that a product the wrong way round shows.
SHEAR = np.array([[1.0, 2.0, 2.0, 1.0], [0.0, 1.0, 2.0, 3.0], [2.0, 0.0, 1.0, 1.0], [1, 0, 0, 1]])


def prop(
    solid: Geometry,
    camera: Camera,
    *,
    model: Matrix | None = None,
    cell: Cell | None = None,
    **state: Any,
) -> Draw:
    """A painted solid that a plain model–view–projection chain puts on the stage.

    Args:
        solid: with colours, `aColor`.
        camera: the uniforms `view` and `projection`.
        model: where it stands; the identity by default.
        cell: the part of the target to draw into.
        state: what else `State` takes.

    >>> prop({"attributes": {"aPos": np.zeros((3, 3))}, "indices": np.arange(3)},
    ...      {}).uniforms["normalMatrix"].diagonal().tolist()
    [1.0, 1.0, 1.0]
    """
    model = np.eye(4) if model is None else np.asarray(model, float)
    uniforms = {"model": model, "normalMatrix": normal_matrix(model), **camera}
    return subject("ch03_transforms/studio.vert", solid, uniforms, cell=cell, **state)


def subject(
    vertex: str,
    solid: Geometry,
    uniforms: Mapping[str, Any],
    *,
    cell: Cell | None = None,
    **state: Any,
) -> Draw:
    """What a lesson is about: a painted solid under a vertex shader of its own, lit like a prop."""
    shaders = (vertex, "ch03_transforms/studio.frag")
    return tested(shaders, solid, uniforms, cell=cell, **state)


def picture_checks(*outputs: str, edges: float = 0.0005, tested: bool = True) -> tuple[Any, ...]:
    """What must hold of `photographed`: its smooth edges, what is seen in it, and the same surfaces
    in any order.

    Args:
        outputs: of the pass "judged" beside FragColor.
        edges: the share of small pixels that may be unlike the large ones about their places.
        tested: as in `any_order`.

    >>> [check.name for check in picture_checks("box")][2:]
    ['judged.FragColor: any order of drawing', 'judged.box: any order of drawing']
    """
    names = ("FragColor", *outputs)
    orders = (any_order(f"judged.{name}", tested=tested) for name in names)
    return (softened_check(), smaller_check(edges=edges), *orders)


def checks(
    *outputs: str, props: bool = True, light: bool = True, edges: float = 0.0005
) -> list[Any]:
    """What must hold of `photographed` whatever the lesson: `picture_checks`, the props, and of the
    last draw its light and that it hands on its colours.

    Args:
        outputs, edges: as in `picture_checks`.
        props: whether the first draw is a `prop`.
        light: whether the last draw is lit where the scene has no such surface; False where it is
            lit by the props' own shader.

    >>> [check.name for check in checks()][-2:]
    ['the last draw: brighter than white', 'judged.Color']
    """
    return [
        *picture_checks(*outputs, edges=edges),
        *(prop_checks() if props else ()),
        *(light_checks(of="the last draw: " if props else "") if light else ()),
        formula("judged.Color", handed_on),
    ]


def color_checks(draws: Mapping[int, str], named: str = "colour, {}") -> list[Any]:
    """Draws in the studio's light: draw → its name.

    >>> [check.name for check in color_checks({1: "ball"})]
    ['colour, ball']
    """
    return each_draw("judged.FragColor", studio_color, draws, named)


def prop_checks(*, draw: int = 0, pass_name: str = "judged") -> list[Any]:
    """What must hold of a prop: its vertices and pixels, and one colour under a long normal.

    >>> [check.name for check in prop_checks()][0]
    'a prop in clip space'
    """
    place, normal = f"{pass_name}.gl_Position", f"{pass_name}.Normal"
    through = {"aPos": (1.0, 2.0, 3.0), "model": SHEAR, "view": np.eye(4), "projection": SHEAR}
    return [
        formula(place, clip_position, draw=draw, name="a prop in clip space"),
        figure(
            place,
            "matrices before columns",
            through,
            (48.0, 29.0, 32.0, 14.0),
            reference=clip_position,
            draw=draw,
        ),
        formula(normal, world_normal, draw=draw, name="a prop's normals"),
        figure(
            normal,
            "a normal by the matrix given",
            {"aNormal": (1.0, 2.0, 3.0), "normalMatrix": SHEAR[:3, :3]},
            (11.0, 8.0, 5.0),
            reference=world_normal,
            draw=draw,
        ),
        formula(f"{pass_name}.Color", handed_on, draw=draw, name="a prop's colours"),
        formula(f"{pass_name}.FragColor", studio_color, draw=draw, name="a prop in the light"),
        *light_checks(draw=draw, pass_name=pass_name),
    ]


def light_checks(*, draw: int = -1, pass_name: str = "judged", of: str = "") -> list[Any]:
    """The studio's light on surfaces that a scene may lack: turned away, black, too bright.

    `of` says what is lit, where several draws are judged.

    >>> [check.name for check in light_checks()][0]
    'grey, facing up'
    """
    grey, green, up = (0.5, 0.5, 0.5), (0.2, 0.4, 0.6), (0.0, 2.0, 0.0)
    rows = (
        ("grey, facing up", grey, up, (0.742866, 0.742866, 0.742866)),
        ("towards the lamp", green, (-2.0, 1.0, 2.0), (0.471116, 0.645595, 0.776250)),
        ("away from the lamp", green, (2.0, -1.0, -2.0), (0.317252, 0.434747, 0.522730)),
        ("black, as dark as it gets", (0.0, 0.0, 0.0), up, (0.0, 0.0, 0.0)),
        ("brighter than white", (4.0, 4.0, 4.0), up, (1.0, 1.0, 1.0)),
    )
    return figures(
        f"{pass_name}.FragColor",
        {
            f"{of}{name}": ({"Color": color, "Normal": normal}, (*equals, 1.0))
            for name, color, normal, equals in rows
        },
        reference=studio_color,
        draw=draw,
    )


def gallery(
    panel: Callable[[Cell, Any], Iterable[Draw]],
    entries: Iterable[Any],
    columns: int,
    size: tuple[int, int],
) -> tuple[Pass, ...]:
    """The passes of `photographed` for a panel of each entry, row by row from the topmost.

    Args:
        panel: what to draw into a cell for an entry.
        entries: what `panel` gets, one a cell.
        columns: of the grid.
        size: of the picture in pixels.

    >>> corners = {"attributes": {"aPos": np.zeros((3, 3))}, "indices": np.arange(3)}
    >>> passes = gallery(lambda at, _: [prop(corners, {}, cell=at)], "abc", 2, (256, 256))
    >>> [draw.state.cell.row for draw in passes[0].draws]
    [1, 1, 0]
    """
    entries = tuple(entries)
    rows = -(-len(entries) // columns)
    cells = (cell(k, columns, rows, from_above=True) for k in range(len(entries)))
    drawn = (panel(at, entry) for at, entry in zip(cells, entries, strict=True))
    return photographed([draw for draws in drawn for draw in draws], size)


def photographed(
    draws: Sequence[Draw],
    size: tuple[int, int],
    clear: tuple[float, float, float, float] = SKY,
    depth: str = "depth24",
    *,
    reordered: Sequence[Draw] = (),
) -> tuple[Pass, ...]:
    """Passes "scene" and "picture" for people, and "judged" (`both_ways`) for checks.

    Args:
        draws: the same for all of them.
        size: of the picture in pixels; at least 256 each way, or it is shown enlarged.
        clear: the background.
        depth: format of the depth buffer, "depth24_stencil8" where the draws test the stencil.
        reordered: the draws of "judged-backwards", if `both_ways` would draw another picture or
            the same triangles in the same order.
    """
    width, height = size
    small = Target(size=(96, 2 * round(48 * height / width)), depth=depth, clear=clear)
    large = replace(small, size=(2 * width, 2 * height), colors={"FragColor": "rgba32f"})
    backwards, judged = both_ways(Pass(name="judged", target=small, draws=tuple(draws)))
    return (
        Pass(name="scene", target=large, draws=tuple(draws)),
        *softened_pass("scene", size, domain={}),
        replace(backwards, draws=tuple(reordered)) if reordered else backwards,
        judged,
    )
