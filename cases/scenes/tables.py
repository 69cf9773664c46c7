"""Tables as pictures: a pass of one texel a field, shown as verdicts, numbers or colours."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from shaderlab import Output, Pass, Texture, boundaries, formula
from shaderlab.glslmath import (
    Value,
    abs,
    clamp,
    distance,
    dot,
    floor,
    fract,
    max,
    min,
    mix,
    smoothstep,
    swizzle,
    vec2,
    vec3,
    vec4,
    where,
)
from shaderlab.glslmath.sampling import Sampler, texelFetch

from .panel_checks import enlarged_check
from .panels import enlarged, panel, picture, rectangle

DIGITS = (
    "### .#. ### ### #.# ### ### ### ### ###",
    "#.# ##. ..# ..# #.# #.. #.. ..# #.# #.#",
    "#.# .#. ### ### ### ### ### ..# ### ###",
    "#.# .#. #.. ..# ..# ..# #.# .#. #.# ..#",
    "### ### ### ### ..# ### ### .#. ### ###",
)
"""The ten figures in dots, row by row from above."""
WIDE, HIGH, PITCH = 0.18, 0.42, 0.25
"""A figure's size and the distance of two, in fields."""


def shown(
    kind: str,
    values: str,
    fields: tuple[int, int],
    pixels: tuple[int, int],
    **uniforms: float | tuple[float, ...],
) -> tuple[Pass, Pass]:
    """A table's picture, and the pass "small", a third as wide and high, by which it is judged.

    Args:
        kind: of LAWS; the shader has this name, in chapter 6.
        values: the output that has the table, "pass.name".
        fields: of the table, across and up.
        pixels: of a field in the small pass.
        uniforms: what else the shader asks for.

    >>> [one.target.size for one in shown("fields", "table.total", (3, 2), (8, 8))]
    [(72, 48), (24, 16)]
    """
    domain, textures = {"place": rectangle((0.0, 0.0), fields)}, {"values": Output(values)}
    draw = panel(f"ch06_tests/{kind}.frag", domain, uniforms, textures=textures)
    return enlarged([draw], (fields[0] * pixels[0], fields[1] * pixels[1]), 3)


def shown_checks(kind: str) -> tuple[Any, ...]:
    """What must hold of `shown`.

    >>> [check.name for check in shown_checks("numbers")]
    ['the table on show', 'the picture is the judged one, enlarged']
    """
    return shown_check(kind), enlarged_check()


def shown_check(kind: str, of: str = "small", name: str = "the table on show") -> Any:
    """The fields of a pass of one of these shaders.

    >>> shown_check("numbers").output
    'small.FragColor'
    """
    return formula(f"{of}.FragColor", LAWS[kind], name=name)


def edges_check(kind: str, of: str = "small") -> Any:
    """The same between the middles of pixels, where fields, figures and lines begin.

    >>> edges_check("numbers").kind
    'boundaries'
    """
    return boundaries(f"{of}.FragColor", LAWS[kind], name="edges in the table")


def all_figures(name: str = "figures") -> Pass:
    """Numbers of one, two and three figures, in which each of the ten is found, for the checks.

    >>> all_figures().target.size
    (210, 60)
    """
    numbers = np.array([[0, 7, 30, 49, 58, 61, 82], [9, 10, 99, 100, 198, 208, 254]], np.float32)
    values = Texture(image=numbers[..., None], format="r32f")
    uniforms = {"group": 3.0, "whole": 255.0}
    domain = {"place": rectangle((0.0, 0.0), numbers.shape[::-1])}
    draw = panel("ch06_tests/numbers.frag", domain, uniforms, textures={"values": values})
    return picture([draw], (210, 60), name)


def numbers(values: Sampler, place: Value, group: Value, whole: Value) -> Value:
    """Each field's number on a ground that is brighter the larger it is, up to `whole`; lines
    between the fields, wider ones between groups of columns."""
    value = swizzle(texelFetch(values, floor(place)), "r")
    color = mix(vec3(0.09, 0.13, 0.22), vec3(0.98, 0.86, 0.55), value / whole)
    ink = where(value < 0.5 * whole, vec3(0.95), vec3(0.08))
    at, column = fract(place), swizzle(place, "x") / group
    color = mix(color, ink, _written(at, value))
    seam = abs(fract(column + 0.5) - 0.5) * group < 0.06
    line = min(swizzle(at, "x"), swizzle(at, "y")) < 0.03
    return vec4(where(line | seam, vec3(0.5), color), 1.0)


def fields(values: Sampler, place: Value) -> Value:
    """Each field's colour, cut to 0…1, and its alpha as grey in the lower right half."""
    value, at = texelFetch(values, floor(place)), fract(place)
    x, y = swizzle(at, "x"), swizzle(at, "y")
    color = clamp(where(y - x > 0.02, swizzle(value, "rgb"), swizzle(value, "aaa")), 0.0, 1.0)
    return vec4(where(min(x, y) < 0.06, vec3(0.25), color), 1.0)


def verdicts(values: Sampler, place: Value, group: Value) -> Value:
    """A green field with a tick for each 1, a red one with a cross for each 0; gaps between
    groups."""
    passed = swizzle(texelFetch(values, floor(place)), "r") > 0.5
    at = 2.0 * fract(place) - 1.0
    tick = min(
        _to_stroke(at, (-0.42, 0.02), (-0.12, -0.32)), _to_stroke(at, (-0.12, -0.32), (0.42, 0.36))
    )
    cross = min(
        _to_stroke(at, (-0.32, -0.32), (0.32, 0.32)), _to_stroke(at, (-0.32, 0.32), (0.32, -0.32))
    )
    ground = where(passed, vec3(0.16, 0.55, 0.34), vec3(0.62, 0.20, 0.20))
    color = mix(vec3(0.97), ground, smoothstep(0.07, 0.13, where(passed, tick, cross)))
    outer = max(abs(swizzle(at, "x")), abs(swizzle(at, "y")))
    color = mix(color, vec3(0.08, 0.09, 0.11), smoothstep(0.84, 0.90, outer))
    off = group * abs(fract(place / group + 0.5) - 0.5)
    gap = min(swizzle(off, "x"), swizzle(off, "y")) <= 0.16
    return vec4(mix(color, vec3(0.08, 0.09, 0.11), where(gap, 1.0, 0.0)), 1.0)


LAWS: dict[str, Callable[..., Value]] = {"numbers": numbers, "fields": fields, "verdicts": verdicts}


def _to_stroke(at: Value, start: tuple[float, float], end: tuple[float, float]) -> Value:
    """How far a place is from a straight stroke."""
    along = vec2(end[0] - start[0], end[1] - start[1])
    off = at - vec2(*start)
    part = clamp(dot(off, along) / dot(along, along), 0.0, 1.0)
    return distance(off, part * along)


def _written(at: Value, number: Value) -> Value:
    """1 on the dots of a number of up to three figures in the middle of a field."""
    more = [where(number > least, 1.0, 0.0) for least in (9.5, 99.5)]
    left = 0.5 - 0.5 * WIDE - 0.5 * PITCH * (more[0] + more[1])
    across = swizzle(at, "x") - left
    # Which figure of the number; the next one begins where there is nothing between the two.
    place = min(max(floor(across / PITCH + 0.1), 0.0), more[0] + more[1])
    power = more[0] + more[1] - place
    tens = floor((number + 0.5) / where(power > 1.5, 100.0, where(power > 0.5, 10.0, 1.0)))
    # Sums in another order may be off a whole number: then no dot would be decided.
    digit = floor(tens - 10.0 * floor((tens + 0.5) / 10.0) + 0.5)
    column = floor((across - PITCH * place) * (3.0 / WIDE))
    row = floor((swizzle(at, "y") - (0.5 - 0.5 * HIGH)) * (5.0 / HIGH))
    return _lit(column, row, digit)


def _lit(column: Value, row: Value, digit: Value) -> Value:
    """1 where a figure has a dot in this column from the left and row from below."""
    whole: Value = 0.0  # all dots of the figure: the bit 3·row + column of each
    for number in range(10):
        rows = [line.split()[number] for line in reversed(DIGITS)]
        bits = sum(1 << k for k, mark in enumerate("".join(rows)) if mark == "#")
        whole = where(digit == number, float(bits), whole)
    bit: Value = where(column == 1.0, 2.0, where(column == 2.0, 4.0, 1.0))
    for k in range(1, 5):
        bit = where(row == k, 8.0**k, 1.0) * bit
    half = floor((whole + 0.5) / bit)
    inside = (column >= 0.0) & (column <= 2.0) & (row >= 0.0) & (row <= 4.0)
    return where(inside & (half - 2.0 * floor(0.5 * half + 0.25) > 0.5), 1.0, 0.0)
