"""Pictures made of panels: cells of a grid, squares of coordinates, a picture at half its size."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab import Cell, Draw, Output, Pass, Ramp, State, Target, fullscreen

WHOLE = {"TexCoords": Ramp((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))}
"""A texture's coordinates over all of a panel, as `fullscreen` has them by default."""


def cell(k: int, columns: int, rows: int = 1, *, from_above: bool = False) -> Cell:
    """The k-th cell of a grid, row by row from the lowest one, or from the topmost.

    >>> cell(4, 3, 2).row, cell(4, 3, 2, from_above=True).row
    (1, 0)
    """
    row = k // columns
    return Cell(
        column=k % columns, row=rows - 1 - row if from_above else row, columns=columns, rows=rows
    )


def square(low: float = -1.0, high: float = 1.0) -> Ramp:
    """Coordinates from `low` to `high`, to the right and upward; device coordinates by default.

    >>> square(0.0, 2.0).dx
    (2.0, 0.0)
    """
    return rectangle((low, low), (high - low, high - low))


def rectangle(origin: Sequence[float], size: Sequence[float]) -> Ramp:
    """Coordinates that begin at `origin`, lower left, and span `size`, to the right and upward.

    >>> rectangle((0.0, 0.0), (4.0, 2.0)).dy
    (0.0, 2.0)
    """
    return Ramp(tuple(origin), (size[0], 0.0), (0.0, size[1]))


def centres(side: int) -> npt.NDArray[Any]:
    """The pixels' centres of a square target, in device coordinates, row by row from below.

    >>> centres(2)[0].tolist()
    [[-0.5, -0.5], [0.5, -0.5]]
    """
    places = (np.arange(side) + 0.5) / side * 2.0 - 1.0
    return np.stack(np.meshgrid(places, places), axis=-1)


def panel(
    fragment: str,
    domain: Mapping[str, Ramp],
    uniforms: Mapping[str, Any] | None = None,
    *,
    textures: Mapping[str, Any] | None = None,
    cell: Cell | None = None,
    **state: Any,
) -> Draw:
    """A fragment shader over one cell of the target, or over all of it.

    Args:
        fragment: the shader.
        domain: its inputs over the panel; none if it is empty.
        uniforms, textures: as `Draw` takes them.
        cell: the part of the target.
        state: what else `State` takes.
    """
    return Draw(
        fragment=fragment,
        domain=domain,
        uniforms=uniforms or {},
        textures=textures or {},
        state=State(cell=cell, **state),
    )


def picture(
    draws: Iterable[Draw], size: tuple[int, int] | None, name: str = "picture", **target: Any
) -> Pass:
    """A pass of several draws into a target of this size, or of the case's own if that is None;
    `target` is what else `Target` takes.

    >>> picture([panel("a.frag", {})], (64, 32)).target.size
    (64, 32)
    """
    return Pass(name=name, target=Target(size=size, **target), draws=tuple(draws))


def panel_pass(
    name: str,
    fragment: str,
    domain: Mapping[str, Ramp],
    uniforms: Mapping[str, Any] | None = None,
    *,
    size: tuple[int, int] | None = None,
    textures: Mapping[str, Any] | None = None,
    **target: Any,
) -> Pass:
    """A pass that runs a fragment shader over all of a target of its own.

    Args:
        name: of the pass.
        fragment, domain, uniforms, textures: as in `panel`.
        size: of the target; a case's own by default.
        target: what else `Target` takes.

    >>> panel_pass("ramp", "a.frag", {"alpha": square(0.0, 1.0)}, size=(200, 8)).target.size
    (200, 8)
    """
    return picture([panel(fragment, domain, uniforms, textures=textures)], size, name, **target)


def table(
    fragment: str,
    domain: Mapping[str, Ramp],
    fields: Sequence[Mapping[str, Any]],
    columns: int,
    size: tuple[int, int],
    name: str = "picture",
    **target: Any,
) -> Pass:
    """A pass of panels in a grid, row by row from the lowest one.

    Args:
        fragment, domain: what all panels share.
        fields: what `panel` takes for each: `uniforms`, `textures`.
        columns: of the grid.
        size: of the target; `target` is what else `Target` takes.
        name: of the pass.

    >>> table("a.frag", {}, [{}, {}, {}, {}], 2, (64, 64)).draws[3].state.cell.row
    1
    """
    rows = -(-len(fields) // columns)
    draws = (
        panel(fragment, domain, **field, cell=cell(k, columns, rows))
        for k, field in enumerate(fields)
    )
    return picture(draws, size, name, **target)


def enlarged(
    draws: Iterable[Draw], small: tuple[int, int], by: int, *, judged: str = "small", **target: Any
) -> tuple[Pass, Pass]:
    """The pass "picture" for people, and the same draws into a small pass for the checks.

    Args:
        draws: whose places go by cells of the target.
        small: size of the small pass; its outputs are all kept, of the picture FragColor alone.
        by: how much larger the picture is. Odd, so that each small pixel has the centre of a large
            one.
        judged: name of the small pass.
        target: what else `Target` takes.

    >>> [one.target.size for one in enlarged([panel("a.frag", {})], (8, 4), 3)]
    [(24, 12), (8, 4)]
    """
    draws, size = tuple(draws), (by * small[0], by * small[1])
    colors = {"colors": {"FragColor": "rgba32f"}, **target}
    return picture(draws, size, **colors), picture(draws, small, judged, **target)


def softened_pass(
    of: str, size: tuple[int, int], name: str = "picture", *, domain: Any = None
) -> tuple[Pass, ...]:
    """A pass at half the size, each pixel the mean of four texels of the pass `of`."""
    return fullscreen(
        "ch03_transforms/soften.frag",
        name=name,
        domain=domain,
        textures={"scene": Output(f"{of}.FragColor")},
        target=Target(size=size),
    )
