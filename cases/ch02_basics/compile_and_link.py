"""Compiling and linking: each stage is checked by itself, then the stages against each other.

A compiler sees one shader at a time. It finds what is wrong with that text: a missing semicolon, an
undeclared name, a profile that the version does not have. What one stage hands to the
next it can't know; that an output and the input of the same name differ in type, or that a stage
has no `main`, is found when the program is linked. A program that was never asked whether it
compiled and linked draws nothing, and does not say why.

Look at: the panels. Each has a lamp for the vertex shader, the fragment shader and the link: green
for good, red for refused, dark for never reached. From the upper left: no semicolon, an undeclared
name, a profile that does not exist; no main, types that differ, and the program that is right,
which alone draws its triangle. The table has every message, with file and line, in glslang's words
and in the driver's.
"""

import numpy as np

from shaderlab import Case, Mesh, Pass, State, compile_fails, formula, mesh_pass
from shaderlab.glslmath import abs, dot, max, min, swizzle, vec2, vec3, where

from ..scenes.figures import each_draw
from ..scenes.laws import device_place, opaque, unchanged
from ..scenes.panels import cell, enlarged, enlarged_check, panel, square

GOOD, BAD, NEVER = (0.30, 0.75, 0.40), (0.85, 0.25, 0.20), (0.20, 0.24, 0.30)
PANELS = [
    (GOOD, BAD, NEVER),  # no semicolon
    (GOOD, BAD, NEVER),  # undeclared
    (GOOD, BAD, NEVER),  # es profile
    (GOOD, GOOD, BAD),  # no main
    (GOOD, GOOD, BAD),  # types differ
    (GOOD, GOOD, GOOD),
]
CORNERS = np.array([(-0.5, -0.3, 0.0), (0.5, -0.3, 0.0), (0.0, 0.7, 0.0)])
VERTEX = "ch02_basics/compile_and_link.vert"
CELLS = [cell(k, 3, 2, from_above=True) for k in range(6)]
# Three lamps and an empty outline each.
LAMPS = [
    panel("ch02_basics/compile_and_link_panel.frag", {"place": square()}, {"lamps": lamps}, cell=at)
    for lamps, at in zip(PANELS, CELLS, strict=True)
]


def right(**state):
    """The triangle of the program that is right."""
    shaders = VERTEX, "ch02_basics/compile_and_link.frag"
    return mesh_pass(*shaders, Mesh(attributes={"aPos": CORNERS}), **state)[0].draws[0]


def corner_color(aPos):
    """The corner's own colour."""
    return 0.5 + aPos


def lit_lamps(place, lamps):
    """A panel: its frame, the outline of CORNERS, and three lamps on a wire."""
    x, y = swizzle(place, "x"), swizzle(place, "y")
    outer = max(abs(x), abs(y)) > 0.96
    color = where(outer, vec3(0.05, 0.06, 0.08), vec3(0.10, 0.13, 0.18))
    # From the base, and from the sides, which fall by 2 on the way of 1.
    inside = min(y + 0.3, 0.7 - y - 2.0 * abs(x))
    color = where((inside > 0.0) & (inside < 0.04), vec3(0.30, 0.36, 0.44), color)
    wire = (abs(x) < 0.5) & (abs(y + 0.65) < 0.02)
    color = where(wire, vec3(0.36, 0.42, 0.50), color)
    for lamp, across in zip(lamps, (-0.5, 0.0, 0.5), strict=True):
        away = place - vec2(across, -0.65)
        color = where(dot(away, away) < 0.15 * 0.15, lamp, color)
    return color


def fails(file, line, message, name):
    """The program with one of the broken fragment shaders: glslang's words, file and line."""
    broken = f"ch02_basics/errata/{file}.frag"
    return compile_fails((VERTEX, broken), (broken, line, message), name=name)


case = Case(
    title="Compiling and linking",
    section="2.2.4",
    math=r"\text{compile}(v) \wedge \text{compile}(f) \wedge \text{link}(v, f)",
    passes=(
        *enlarged((*LAMPS, right(state=State(cell=CELLS[5]))), (81, 54), 9),
        Pass(draws=(right(),)),
    ),
    picture="picture.FragColor",
    expect=[
        fails(
            "no_semicolon",
            9,
            "syntax error, unexpected RIGHT_BRACE, expecting COMMA or SEMICOLON",
            "a missing semicolon",
        ),
        fails("undeclared", 8, "'colour' : undeclared identifier", "an undeclared name"),
        fails(
            "es_profile",
            1,
            "only version 300, 310, and 320 support the es profile",
            "a profile that 330 does not have",
        ),
        fails(
            "no_main",
            None,
            "Linking fragment stage: Missing entry point: Each stage requires one entry point",
            "no main",
        ),
        fails(
            "type_mismatch",
            2,
            "Linking vertex and fragment stages: Types must match:\n"
            '    vertex stage: " vec3 color"\n'
            '    fragment stage: " vec4 color"',
            "an output and an input that differ in type",
        ),
        enlarged_check(),
        *each_draw("small.FragColor", opaque(lit_lamps), {k: f"panel {k + 1}" for k in range(6)}),
        formula("small.FragColor", opaque(unchanged("color")), name="the triangle in its panel"),
        formula("gl_Position", device_place),
        formula("color", corner_color),
        formula("FragColor", opaque(unchanged("color")), name="the program that is right"),
    ],
)
