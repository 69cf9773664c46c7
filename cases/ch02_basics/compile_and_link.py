"""Compiling and linking: each stage is checked by itself, then the stages against each other.

A compiler sees one shader at a time. It finds what is wrong with that text: a missing semicolon, a
name that nobody declared, a profile that the version does not have. What one stage hands to the
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

from shaderlab import (
    Case,
    Cell,
    Draw,
    Mesh,
    Pass,
    Ramp,
    State,
    Target,
    compile_fails,
    formula,
    mesh_pass,
)
from shaderlab.glslmath import vec4

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
BROKEN = "ch02_basics/errata"


def cell(k):
    """The k-th panel, row by row from the upper left."""
    return State(cell=Cell(column=k % 3, row=1 - k // 3, columns=3, rows=2))


def panel(k):
    """Three lamps and an empty outline."""
    return Draw(
        fragment="ch02_basics/compile_and_link_panel.frag",
        domain={"place": Ramp((-1.0, -1.0), (2.0, 0.0), (0.0, 2.0))},
        uniforms={"lamps": PANELS[k]},
        state=cell(k),
    )


def right(**state):
    """The triangle of the program that is right."""
    shaders = VERTEX, "ch02_basics/compile_and_link.frag"
    return mesh_pass(*shaders, Mesh(attributes={"aPos": CORNERS}), **state)[0].draws[0]


def handed_on(color):
    """The interpolated colour."""
    return vec4(color, 1.0)


def corner_color(aPos):
    """The corner's own colour."""
    return 0.5 + aPos


def corner(aPos):
    """Device coordinates, with w = 1."""
    return vec4(aPos, 1.0)


case = Case(
    title="Compiling and linking",
    section="2.2.4",
    math=r"\text{compile}(v) \wedge \text{compile}(f) \wedge \text{link}(v, f)",
    passes=(
        Pass(
            name="picture",
            target=Target(size=(768, 512)),
            draws=(*(panel(k) for k in range(6)), right(state=cell(5))),
        ),
        Pass(draws=(right(),)),
    ),
    picture="picture.FragColor",
    expect=[
        compile_fails(
            (VERTEX, f"{BROKEN}/no_semicolon.frag"),
            (
                f"{BROKEN}/no_semicolon.frag",
                9,
                "syntax error, unexpected RIGHT_BRACE, expecting COMMA or SEMICOLON",
            ),
            name="a missing semicolon",
        ),
        compile_fails(
            (VERTEX, f"{BROKEN}/undeclared.frag"),
            (f"{BROKEN}/undeclared.frag", 8, "'colour' : undeclared identifier"),
            name="an undeclared name",
        ),
        compile_fails(
            (VERTEX, f"{BROKEN}/es_profile.frag"),
            (
                f"{BROKEN}/es_profile.frag",
                1,
                "only version 300, 310, and 320 support the es profile",
            ),
            name="a profile that 330 does not have",
        ),
        compile_fails(
            (VERTEX, f"{BROKEN}/no_main.frag"),
            (
                f"{BROKEN}/no_main.frag",
                None,
                "Linking fragment stage: Missing entry point: Each stage requires one entry point",
            ),
            name="no main",
        ),
        compile_fails(
            (VERTEX, f"{BROKEN}/type_mismatch.frag"),
            (
                f"{BROKEN}/type_mismatch.frag",
                2,
                "Linking vertex and fragment stages: Types must match:\n"
                '    vertex stage: " vec3 color"\n'
                '    fragment stage: " vec4 color"',
            ),
            name="an output and an input that differ in type",
        ),
        formula("gl_Position", corner),
        formula("color", corner_color),
        formula("FragColor", handed_on, name="the program that is right"),
    ],
)
