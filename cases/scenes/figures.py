"""Tables of figures: one line for each value that a shader or a formula must give."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

import numpy as np

from shaderlab import Pixel, computed, formula, measure, value


def figure(
    output: str,
    name: str,
    at: Any,
    equals: Any,
    *,
    digits: int = 6,
    reference: Callable[..., Any] | None = None,
    draw: int = -1,
    note: str = "",
) -> Any:
    """One `value`: what it is called, its inputs (or a `Pixel`), and the figure.

    >>> figure("f", "half", {"x": 0.5}, 0.25).name
    'half'
    """
    return value(
        output,
        at=at,
        equals=equals,
        digits=digits,
        reference=reference,
        draw=draw,
        name=name,
        note=note,
    )


def figures(
    output: str,
    rows: Mapping[str, tuple[Any, ...]],
    *,
    at: Mapping[str, Any] | None = None,
    digits: int = 6,
    reference: Callable[..., Any] | None = None,
    draw: int = -1,
) -> list[Any]:
    """A `value` of one output for each row.

    Args:
        output: as in `value`.
        rows: what the figure is → (inputs or a `Pixel`, the figure, and if wanted a note).
        at: inputs that all rows share; a row's own go before them.
        digits, reference, draw: as in `value`.

    >>> one, two = figures("f", {"a": ({"x": 1.0}, 2.0), "b": ({}, 3.0, "odd")}, at={"y": 0.0})
    >>> one.at, one.equals, two.note
    ({'y': 0.0, 'x': 1.0}, 2.0, 'odd')
    """
    return [
        figure(
            output,
            name,
            inputs if isinstance(inputs, Pixel) else {**(at or {}), **inputs},
            equals,
            digits=digits,
            reference=reference,
            draw=draw,
            note="".join(note),
        )
        for name, (inputs, equals, *note) in rows.items()
    ]


def results(rows: Mapping[str, tuple[Any, ...]], *, digits: int = 6) -> list[Any]:
    """A `computed` figure for each row: label → (a function or its result, the figure, and if
    wanted a note).

    >>> [found.equals for found in results({"one": (lambda: 1.0, 1.0), "two": (1.0 + 1.0, 2.0)})]
    [1.0, 2.0]
    """
    return [
        computed(
            label,
            made if callable(made) else partial(_same, made),
            equals=equals,
            digits=digits,
            note="".join(note),
        )
        for label, (made, equals, *note) in rows.items()
    ]


def _same(value: Any) -> Any:
    return value


def each_draw(
    output: str,
    reference: Callable[..., Any],
    draws: Mapping[int, str] | Iterable[tuple[int, str]],
    named: str = "{}",
    **more: Any,
) -> list[Any]:
    """The formula of one output for several draws.

    Args:
        output, reference: as in `formula`; `more` is what else it takes.
        draws: draw → its name.
        named: how the outcome is called, with the draw's name in it.

    >>> [(e.draw, e.name) for e in each_draw("FragColor", abs, {0: "ball", 3: "ring"}, "the {}")]
    [(0, 'the ball'), (3, 'the ring')]
    """
    pairs = draws.items() if isinstance(draws, Mapping) else draws
    return [
        formula(output, reference, draw=draw, name=named.format(name), **more)
        for draw, name in pairs
    ]


def ground(output: str, color: tuple[float, ...], name: str = "the ground") -> Any:
    """What nothing is drawn on has the colour that it was cleared to: the two upper corners of an
    output of 32-bit floats.

    >>> ground("FragColor", (0.5, 0.5, 0.5, 1.0)).name
    'the ground'
    """

    def farthest(FragColor: Any) -> float:
        return float(np.abs(FragColor[-1, [0, -1]] - np.asarray(color)).max())

    return measure(name, farthest, reads={"FragColor": output}, at_most=2.0**-24)
