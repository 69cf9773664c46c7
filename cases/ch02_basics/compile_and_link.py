"""Compiling and linking: each stage is checked alone, then the stages against each other.

A compiler sees one shader at a time. It finds what is wrong with that text: a missing semicolon, an
undeclared name, a profile that the version does not have. It can't know what one stage passes to
the next. The linker finds an output and an input of one name but different types, or a stage
without `main`. If nobody checks whether a program compiled and linked, it draws nothing and does
not say why.

Look at: the panels. Each has a lamp for the vertex shader, the fragment shader and the link: green
for accepted, red for refused, dark for never reached. From the upper left: a misspelt gl_Position,
three numbers instead of four, a missing semicolon, an undeclared name; a profile that does not
exist, no main, types that differ, and the correct program, the only one that draws its triangle.
The table has every message, with file and line, in glslang's words and in the driver's.

Try: in `ch02_basics/compile_and_link.frag` write `flat in vec3 color` for `in vec3 color`: both
stages still compile, but the driver refuses to link them, and the run says why.
"""

from dataclasses import replace

import numpy as np

from shaderlab import Case, Mesh, Pass, State, boundaries, compile_fails, formula, mesh_pass
from shaderlab.engine.expectations.gl_call import Object, call
from shaderlab.glslmath import abs, dot, max, min, swizzle, vec2, vec3, where

from ..scenes.api import answers
from ..scenes.figures import each_draw
from ..scenes.laws import device_place, opaque, unchanged
from ..scenes.objects import compiled, linked
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, square

VERTEX = "ch02_basics/compile_and_link.vert"
GOOD, BAD, NEVER = (0.30, 0.75, 0.40), (0.85, 0.25, 0.20), (0.20, 0.24, 0.30)
FRAGMENT = "ch02_basics/compile_and_link.frag"
# What is refused, and when: the broken file, the line, the whole message, what is wrong.
REFUSED = (
    (
        "vertex", "misspelt.vert", 9, "'gl_Positon' : undeclared identifier",
        "a misspelt gl_Position",
    ),
    (
        "vertex", "three_of_four.vert", 9,
        "'assign' : cannot convert from 'layout( location=0) in 3-component vector of float' to "
        "' gl_Position 4-component vector of float Position'",
        "three numbers for a position",
    ),
    (
        "fragment", "no_semicolon.frag", 9,
        "syntax error, unexpected RIGHT_BRACE, expecting COMMA or SEMICOLON", "a missing semicolon",
    ),
    (
        "fragment", "undeclared.frag", 8, "'colour' : undeclared identifier", "an undeclared name",
    ),
    (
        "fragment", "es_profile.frag", 1, "only version 300, 310, and 320 support the es profile",
        "a profile that 330 does not have",
    ),
    (
        "link", "no_main.frag", None,
        "fragment stage: Missing entry point: Each stage requires one entry point", "no main",
    ),
    (
        "link", "type_mismatch.frag", 2,
        "vertex and fragment stages: Types must match:\n"
        '    vertex stage: " vec3 color"\n'
        '    fragment stage: " vec4 color"',
        "an output and an input that differ in type",
    ),
)  # fmt: skip
STAGES = {
    "vertex": (BAD, GOOD, NEVER), "fragment": (GOOD, BAD, NEVER), "link": (GOOD, GOOD, BAD),
}  # fmt: skip
PANELS = [*(STAGES[stage] for stage, *_ in REFUSED), (GOOD, GOOD, GOOD)]
CORNERS = np.array([(-0.5, -0.3, 0.0), (0.5, -0.3, 0.0), (0.0, 0.7, 0.0)])
CELLS = [cell(k, 4, 2, from_above=True) for k in range(8)]
# Three lamps and an empty outline each.
LAMPS = [
    panel("ch02_basics/compile_and_link_panel.frag", {"place": square()}, {"lamps": lamps}, cell=at)
    for lamps, at in zip(PANELS, CELLS, strict=True)
]


def right(**state):
    """The triangle of the program that is right."""
    return mesh_pass(VERTEX, FRAGMENT, Mesh(attributes={"aPos": CORNERS}), **state)[0].draws[0]


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


def fails(stage, file, line, message, name):
    """The program with one of the broken shaders, which this stage refuses: glslang's words, and
    the file and line of both compilers. The linker's messages say so; it has no line for the
    driver."""
    broken = f"ch02_basics/errata/{file}"
    shaders = (broken, FRAGMENT) if stage == "vertex" else (VERTEX, broken)
    if stage == "link":
        # NVIDIA's linker lets a vec4 read a vec3.
        departs = {"NVIDIA": "accepted"} if file == "type_mismatch.frag" else {}
        place = (broken, line, f"Linking {message}")
        return compile_fails(shaders, place, departs=departs, name=name)
    return compile_fails(shaders, (broken, line, message), driver=(broken, line), name=name)


VERT, FRAG, LINKED = Object("vertex_shader"), Object("fragment_shader"), Object("program")
HEAD = "#version 330 core\n"
GIVES = HEAD + "out vec3 hue;\nvoid main() { hue = vec3(1.0); gl_Position = vec4(hue, 1.0); }\n"
TAKES = HEAD + "in vec3 hue;\nout vec4 color;\nvoid main() { color = vec4(hue, 1.0); }\n"


def asked(what, shader=VERT):
    """What glGetShaderiv answers, or for a program glGetProgramiv."""
    kind = "Program" if shader == LINKED else "Shader"
    return call(f"glGet{kind}iv", shader, f"GL_{what}")


MISSPELT = compiled(VERT, GIVES.replace("gl_Position", "gl_Positon"))
VEC2 = TAKES.replace("in vec3", "in vec2").replace("hue,", "hue, 0.0,")
RIGHT, MISMATCHED = (linked(LINKED, {VERT: GIVES, FRAG: text}) for text in (TAKES, VEC2))
DELETED = (call("glDeleteShader", VERT),)
GONE = "… and is gone when it is detached"
STATUSES = {
    "a shader that is right: GL_COMPILE_STATUS": (
        asked("COMPILE_STATUS"), "GL_TRUE", compiled(VERT, GIVES)
    ),
    "gl_Positon: GL_COMPILE_STATUS": (asked("COMPILE_STATUS"), "GL_FALSE", MISSPELT),
    "a program that is right: GL_LINK_STATUS": (
        asked("LINK_STATUS", LINKED), "GL_TRUE", RIGHT
    ),
    "types that differ: GL_LINK_STATUS": (asked("LINK_STATUS", LINKED), "GL_FALSE", MISMATCHED),
    "… though each shader is right": (asked("COMPILE_STATUS", FRAG), "GL_TRUE", MISMATCHED),
    "glDeleteShader after linking marks the shader": (
        asked("DELETE_STATUS"), "GL_TRUE", RIGHT, DELETED
    ),
    "… which lives on while it is attached": (call("glIsShader", VERT), "GL_TRUE", RIGHT, DELETED),
    GONE: (
        call("glIsShader", VERT), "GL_FALSE", RIGHT, DELETED,
        (call("glDetachShader", LINKED, VERT),),
    ),
    "… and the program stays linked": (
        asked("LINK_STATUS", LINKED), "GL_TRUE", RIGHT, DELETED
    ),
    "without an error the shader's log is empty": (
        asked("INFO_LOG_LENGTH"), 0, compiled(VERT, GIVES)
    ),
}  # fmt: skip
# How long a log is, and its first character: every driver has its own words.
LOGS = {
    "the shader's log has a text": (asked("INFO_LOG_LENGTH"), 2, MISSPELT),
    "glGetShaderInfoLog writes it": (call("glGetShaderInfoLog", VERT, 512, None), 32, MISSPELT),
    "the program's log has a text": (asked("INFO_LOG_LENGTH", LINKED), 2, MISMATCHED),
    "glGetProgramInfoLog writes it": (
        call("glGetProgramInfoLog", LINKED, 512, None), 32, MISMATCHED
    ),
}  # fmt: skip

case = Case(
    title="Compiling and linking",
    section="2.2.4",
    math=r"\text{compile}(v) \wedge \text{compile}(f) \wedge \text{link}(v, f)",
    passes=(
        *enlarged((*LAMPS, right(state=State(cell=CELLS[7]))), (108, 54), 7),
        Pass(draws=(right(),)),
    ),
    picture="picture.FragColor",
    expect=[
        *(fails(*refused) for refused in REFUSED),
        *answers(STATUSES, {GONE: {"NVIDIA": "GL_ONE"}}),  # the linked program keeps it there
        *(replace(check, at_least=True) for check in answers(LOGS)),
        enlarged_check(),
        *each_draw("small.FragColor", opaque(lit_lamps), {k: f"panel {k + 1}" for k in range(8)}),
        boundaries("small.FragColor", opaque(lit_lamps), draw=0, name="a panel's edges"),
        formula("small.FragColor", opaque(unchanged("color")), name="the triangle in its panel"),
        formula("gl_Position", device_place),
        formula("color", corner_color),
        formula("FragColor", opaque(unchanged("color")), name="the program that is right"),
    ],
)
