"""A Ferris wheel in the evening without a soft edge, as ch15_beyond/edges_scene.frag draws it."""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab import Output, Pass
from shaderlab.glslmath import Value, abs, clamp, int, length, mix, swizzle, vec3, vec4, where
from shaderlab.glslmath.sampling import texelFetch

from .panels import WHOLE, cell, panel, panel_pass, picture, square

SIDE = 72
_TURNS = np.radians(30.0) * np.arange(12) + 0.2
SPOKES = np.column_stack([np.cos(_TURNS), np.sin(_TURNS)])
_PAINT = (0.95, 0.93, 0.88)
_GONDOLAS = ((0.80, 0.14, 0.14), (0.96, 0.76, 0.18), (0.10, 0.42, 0.50))


def frame(name: str, jitter: tuple[float, float] = (0.0, 0.0)) -> Pass:
    """A pass that draws the wheel, shifted by so many pixels.

    >>> frame("one").target.size
    (72, 72)
    """
    uniforms = {"jitter": tuple(2.0 / SIDE * c for c in jitter), "spokes": SPOKES}
    domain = {"place": square()}
    return panel_pass(name, "ch15_beyond/edges_scene.frag", domain, uniforms, size=(SIDE, SIDE))


def side_by_side(*names: str) -> Pass:
    """The pass "picture": others beside each other, five pixels for one.

    >>> side_by_side("a", "b").target.size
    (720, 360)
    """
    draws = (
        panel(
            "ch02_basics/textured.frag",
            WHOLE,
            textures={"image": Output(f"{name}.FragColor")},
            cell=cell(k, len(names)),
        )
        for k, name in enumerate(names)
    )
    return picture(draws, (5 * len(names) * SIDE, 5 * SIDE))


def wheel(place: Value, jitter: Value, spokes: Any) -> Value:
    """The colour at a place, seen by a camera that is shifted by `jitter`, (…, 4).

    >>> wheel(np.array([0.0, 0.12]), np.zeros(2), SPOKES).tolist()
    [0.95, 0.93, 0.88, 1.0]
    """
    at = place + jitter
    x, y = swizzle(at, "x"), swizzle(at, "y")
    evening = mix(vec3(0.98, 0.72, 0.48), vec3(0.36, 0.45, 0.70), clamp(0.5 * y + 0.55, 0.0, 1.0))
    color = where(y < -0.80, vec3(0.13, 0.16, 0.20), evening)
    off = at - np.array([0.0, 0.12])
    x, y, away = swizzle(off, "x"), swizzle(off, "y"), length(off)
    leg = (abs(abs(x) + 0.42 * y) < 0.034) & (y < 0.0)
    color = where(leg, vec3(0.16, 0.17, 0.24), color)
    for one in spokes[:6]:
        spoke = (abs(swizzle(one, "x") * y - swizzle(one, "y") * x) < 0.012) & (away < 0.66)
        color = where(spoke, vec3(*_PAINT), color)
    ring = (abs(away - 0.66) < 0.026) | (abs(away - 0.36) < 0.014) | (away < 0.07)
    color = where(ring, vec3(*_PAINT), color)
    for k, one in enumerate(spokes):
        gondola = off - 0.66 * one + np.array([0.0, 0.05])
        color = where(length(gondola) < 0.085, vec3(*_GONDOLAS[k % 3]), color)
    return vec4(color, 1.0)


def around(image: Any, frag_coord: Value, offsets: Any) -> list[Value]:
    """Texels about a pixel, those of the border repeated, each (…, 3)."""
    here, last = int(swizzle(frag_coord, "xy")), np.array(image.texels.values.shape[1::-1]) - 1
    return [
        swizzle(texelFetch(image, clamp(here + np.array(off), np.array([0, 0]), last), 0), "rgb")
        for off in offsets
    ]
