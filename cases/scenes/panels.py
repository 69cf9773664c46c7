"""Pictures made of panels: cells of a grid, squares of coordinates, a picture at half its size."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from shaderlab import Cell, Output, Pass, Ramp, Target, fullscreen


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


def softened_pass(
    of: str, size: tuple[int, int], name: str = "picture", *, domain: Any = None
) -> tuple[Pass, ...]:
    """A pass at half the size, each pixel the mean of four texels of the pass `of`."""
    return fullscreen(
        "ch03_transforms/soften.frag",
        name=name,
        domain=domain,
        textures={"scene": Output(of, "FragColor")},
        target=Target(size=size),
    )
