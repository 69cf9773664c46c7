"""Seven vertices in six colours around a white one: 84 bytes of positions, 84 of colours.

Source: The OpenGL Graphics System: A Specification (version 4.5 core profile), M. Segal and
K. Akeley, 2017, §8.3.8 and §17.3.7 for colours that are linear in light; the square root stands
for the display's curve, a gamma of 2.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from shaderlab import Mesh, Pass, formula, value
from shaderlab.glslmath import Value, sqrt, vec4

from .draws import drawn
from .laws import device_place, unchanged
from .panels import picture

PAPER, LIGHT = (0.13, 0.14, 0.17, 1.0), (0.93, 0.93, 0.92, 1.0)
color_of = unchanged("aColor")
RIM = ((1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1), (1, 0, 1))


def rosette(**memory: Any) -> Mesh:
    """A hexagon of six triangles around its centre, in device coordinates.

    Args:
        memory: how it lies in memory: `layout`, `usage` and `upload` of a Mesh.

    >>> rosette(layout="batched").placements()["aColor"].offset
    84
    """
    # Close to a regular hexagon; in a window of 128 pixels all corners lie between pixels.
    half = np.array([(52, 30, 0), (0, 60, 0), (-52, 30, 0)])
    rim = np.vstack([half, -half])
    corners = np.arange(6)
    fan = np.column_stack([np.zeros(6, int), corners + 1, (corners + 1) % 6 + 1])
    return Mesh(
        attributes={
            "aPos": np.vstack([np.zeros(3), rim / 64.0]),
            "aColor": np.vstack([np.ones(3), np.array(RIM, float)]),
        },
        indices=fan.ravel(),
        **memory,
    )


def encoded(ourColor: Value) -> Value:
    """Interpolated light, (…, 3) in 0…1, as the display's numbers, (…, 4).

    >>> encoded((0.25, 1.0, 0.0)).tolist()
    [0.5, 1.0, 0.0, 1.0]
    """
    return vec4(sqrt(ourColor), 1.0)


def window(name: str, *, side: int = 512, clear: Any = PAPER, **memory: Any) -> Pass:
    """A pass of this name that draws one rosette into a square window.

    Args:
        name: of the pass.
        side: of the window in pixels.
        clear: its background.
        memory: as in `rosette`.

    >>> window("batched", layout="batched").target.size
    (512, 512)
    """
    draw = drawn("ch10_buffers/rosette", rosette(**memory))
    return picture([draw], (side, side), name, clear=clear)


def rosette_checks(
    pass_name: str = "", *, places: Callable[..., Any] = device_place, draw: int = -1
) -> list[Any]:
    """What must hold of rosettes: where vertices are, their colours, and the pixels between them,
    one of which is given in figures.

    Args:
        pass_name: the pass that is judged, if it is not the last.
        places: the formula of `gl_Position`; that of device coordinates by default.
        draw: which of the pass's draws.

    >>> [check.output for check in rosette_checks("kept")][:2]
    ['kept.gl_Position', 'kept.ourColor']
    """
    prefix = f"{pass_name}." if pass_name else ""
    laws = {"gl_Position": places, "ourColor": color_of, "FragColor": encoded}
    green, seen = {"ourColor": (0.25, 1.0, 0.0)}, (0.5, 1.0, 0.0, 1.0)
    return [
        *(formula(prefix + output, law, draw=draw) for output, law in laws.items()),
        value(f"{prefix}FragColor", at=green, equals=seen, digits=6),
    ]
