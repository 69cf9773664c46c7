"""The first triangle: three corners, one colour, and the whole pipeline behind them.

The corners are given in normalised device coordinates, where the window reaches from −1 to 1 on
both axes. Each pixel whose centre lies inside the triangle gets the fragment shader's colour. In an
8-bit framebuffer every channel is rounded to a whole number of 255ths; 0.5 falls exactly between
127 and 128, and a driver may store either.

Look at: the number of pixels. The triangle's area is ¼ and the window's is 2 × 2, so it covers 1/16
of the window: 32400 of 720 × 720 pixels. Also look at the two reasons why this shader does not
compile as it stands in the notes. Both look like slips of a conversion to another file format.

Try: in `ch01_setup/orange_triangle.frag` write `0.8, 0.2` for `0.5, 0.2`: the triangle turns
yellow, and the check of its colour fails.
"""

import numpy as np

from shaderlab import Case, Erratum, Pixel, compile_fails, coverage, formula, measure, value
from shaderlab.glslmath import vec4
from shaderlab.reference.transforms import signed_area

from ..scenes.draws import drawn
from ..scenes.figures import results
from ..scenes.panels import picture

CORNERS = np.array([(-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), (0.0, 0.5, 0.0)])
CLEAR = (0.2, 0.3, 0.3, 1.0)
TRIANGLE = drawn("ch01_setup/orange_triangle", {"attributes": {"aPos": CORNERS}})
BYTES = {"colors": {"FragColor": "rgba8"}, "clear": CLEAR}
SHARE = (signed_area(CORNERS) / 4.0, 0.0625, "the window is 2 × 2 in device coordinates")


def orange():
    """Full red, half green, a fifth of blue."""
    return vec4(1.0, 0.5, 0.2, 1.0)


def off_paper(FragColor):
    """How far what lies beside the triangle is from the colour that it was cleared to."""
    beside = np.ones(FragColor.shape[:2], bool)
    beside[360:540, 180:540] = False
    return np.abs(FragColor[beside] / 255.0 - CLEAR).max()


case = Case(
    title="An orange triangle",
    section="1.2.2",
    math=r"\text{FragColor} = (1,\ 0.5,\ 0.2,\ 1)",
    passes=[picture([TRIANGLE], (720, 720), "main", **BYTES)],
    expect=[
        coverage(32400, name="pixels covered"),
        formula("FragColor", orange, name="every pixel is orange"),
        measure("the clear colour around it", off_paper, at_most=0.500001 / 255.0),  # half a step
        value("FragColor", at=Pixel(360, 400), equals=(1.0, 0.5, 0.2, 1.0), digits=6),
        *results({"share of the window": SHARE}, digits=4),
        compile_fails(
            "ch01_setup/errata/version_330_core.frag",
            (1, "'#version' : bad profile name; use es, core, or compatibility"),
            (1, "'#version' : bad tokens following profile -- expected newline"),
            name="#version 330_core is refused",
        ),
        compile_fails(
            "ch01_setup/errata/trailing_zero.frag",
            (7, "syntax error, unexpected INTCONSTANT"),
            name="a trailing 0 is refused",
        ),
        compile_fails(
            "ch01_setup/errata/macro_twice.frag",
            (4, "'#define' : Macro redefined; different substitutions: WIDTH"),
            name="a macro defined twice, in two ways, is refused",
        ),
    ],
    errata=[
        Erratum(
            section="1.2.2",
            says="#version 330_core",
            truth="number and profile are two words: #version 330 core. Most likely lost when "
            "the notes were converted",
            proof="#version 330_core is refused",
        ),
        Erratum(
            section="1.2.2",
            says="the shader's text ends in }0",
            truth="nothing may follow the closing brace but further declarations. Most likely "
            "added when the notes were converted",
            proof="a trailing 0 is refused",
        ),
        Erratum(
            section="1.1",
            says="another meaning is given for Visual C++'s warning C4005",
            truth="C4005 means that a macro is defined a second time, with another text: two "
            "headers define the same name. GLSL has the same rule, and makes it an error",
            proof="a macro defined twice, in two ways, is refused",
        ),
    ],
)
