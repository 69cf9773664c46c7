"""Reading a shader from a file: what can go wrong, and what must not.

A shader is text, and a file holds bytes. The lab reads UTF-8, with or without a byte order mark,
and any line ends. It refuses a text that the compiler could not see in full, and names the file,
the line and the remedy. A NUL character is such a case: C ends a string there, so everything after
it would be silently ignored.

Look at: the first 48 bytes of seven files, one file per row. From above: plain, with a byte order
mark, with carriage returns, in Latin-1, in UTF-16, with a NUL, and empty. Characters are blue, line
feeds green, carriage returns yellow, and bytes that ASCII does not have are red; NUL is black, and
in UTF-16 every second byte is one. The first three draw the same picture, to the bit. The others
are refused, and so are a missing file, a folder, and a file that includes itself.

Try: in `ch02_basics/shader_files.frag` write `byte == 32.0)` for `byte == 10.0)`: spaces are green
in place of line feeds.
"""

from pathlib import Path

import numpy as np

from shaderlab import Case, Output, Texture, boundaries, exact, formula, fullscreen, refused
from shaderlab.glslmath import floor, fract, max, min, mix, swizzle, vec3, vec4, where
from shaderlab.glslmath.sampling import texelFetch

from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import enlarged, panel, rectangle

FILES = "ch02_basics/errata/files"
FOLDER = Path(__file__).parents[2] / "shaders" / FILES
NUL = f"{FILES}/nul.frag"
MISSPELT = f"no shader '{FILES}/emtpy.frag' in shaders"
NEAREST = f"{FILES}/empty.frag or {FILES}/bom.frag or {FILES}/utf16.frag"
SHOWN = ("plain", "bom", "crlf", "latin1", "utf16", "nul", "empty")
COLUMNS = 48
SIZE = (7 * COLUMNS, 14 * len(SHOWN))
PLAIN = Output("plain.FragColor")


def first_bytes():
    """The files' first bytes, the last file in row 0; −1 past a file's end."""
    rows = [(FOLDER / f"{name}.frag").read_bytes()[:COLUMNS] for name in reversed(SHOWN)]
    padded = [[*row] + [-1] * (COLUMNS - len(row)) for row in rows]
    return np.array(padded, np.float32)[..., None]


def kinds():
    """0 for nothing, 1 for a character, then NUL, line feed, carriage return and not ASCII."""
    table = first_bytes()
    kinds = {0: table < 0, 2: table == 0, 3: table == 10, 4: table == 13, 5: table > 127}
    return np.select([*kinds.values()], [*kinds], 1).astype(np.float32)


def drawn(name):
    """A pass that draws with one of the files."""
    return fullscreen(f"{FILES}/{name}.frag", name=name, domain={})


def no(name, message, **place):
    """The file is refused in exactly these words."""
    return refused(f"{FILES}/{name}.frag", message=message, name=f"{name}.frag", **place)


UTF8 = {"remedy": "save the file as UTF-8"}
DELETE = {"remedy": "delete it"}
CYCLE = {"remedy": "break the cycle of includes"}


def circle(name, other, line, back):
    """Two files that include each other, the second one at line `back`."""
    message = f"'{name}.frag' includes itself (included by {FILES}/{name}.frag:{line})"
    return no(name, message, file=f"{FILES}/{other}.frag", line=back, **CYCLE)


BYTES = panel(
    "ch02_basics/shader_files.frag",
    {"field": rectangle((0.0, 0.0), (COLUMNS, len(SHOWN)))},
    textures={"bytes": Texture(image=first_bytes, format="r32f")},
)
DARK, GREY, LIGHT = vec3(0.12, 0.14, 0.17), vec3(0.30, 0.38, 0.50), vec3(0.62, 0.70, 0.80)


def painted(bytes, field):
    """A colour for each kind of byte; characters are the lighter the higher their code is."""
    byte = swizzle(texelFetch(bytes, floor(field)), "r")
    color = mix(GREY, LIGHT, (byte - 33.0) / 94.0)
    color = where(byte == 32.0, vec3(0.22, 0.26, 0.32), color)
    color = where(byte > 127.0, vec3(0.88, 0.30, 0.25), color)
    color = where(byte == 13.0, vec3(0.95, 0.70, 0.25), color)
    color = where(byte == 10.0, vec3(0.35, 0.75, 0.45), color)
    color = where(byte == 0.0, vec3(0.02), where(byte < 0.0, DARK, color))
    left, below = swizzle(fract(field), "x"), swizzle(fract(field), "y")
    gap = (min(left, below) < 0.08) | (max(left, below) > 0.92)
    return vec4(mix(vec3(0.07, 0.08, 0.10), color, where(gap, 0.0, 1.0)), 1.0)


case = Case(
    title="Shaders from files",
    section="2.3.5",
    math=r"\text{text} = \text{UTF-8}^{-1}(\text{bytes})",
    passes=(*drawn("plain"), *drawn("bom"), *drawn("crlf"), *enlarged([BYTES], SIZE, 3)),
    picture="picture.FragColor",
    rows=SHOWN,
    expect=[
        exact("plain.FragColor", (0.25, 0.5, 0.75, 1.0), name="a plain file"),
        exact("bom.FragColor", PLAIN, name="a byte order mark is skipped"),
        exact("crlf.FragColor", PLAIN, name="carriage returns, in an included file as well"),
        formula("small.FragColor", painted, name="the bytes on show"),
        boundaries("small.FragColor", painted, name="… at their edges"),
        enlarged_check(),
        exact("small.kind", kinds(), name="what kind of byte each one is"),
        no("empty", "the shader is empty"),
        no("folder", "is a directory, not a shader", remedy="name a file in it"),
        no("latin1", "is not UTF-8: byte 23 is 0xfc", line=2, **UTF8),
        no("utf16", "is not UTF-8: byte 0 is 0xff (it looks like UTF-16)", **UTF8),
        no("nul", "holds a NUL character, at which compilers stop reading", line=2, **DELETE),
        circle("cycle", "cycle_back", 2, 3),
        circle("cycle_back", "cycle", 3, 2),
        no("itself", "'itself.frag' includes itself", line=2, **CYCLE),
        no(
            "emtpy", f"no shader '{FILES}/emtpy.frag' in shaders", remedy=f"did you mean {NEAREST}?"
        ),
        no(
            "missing",
            f"no file to #include: '{FILES}/folder.frag/color.glsl'",
            line=2,
            remedy=f"did you mean {FILES}/folder.frag/colour.glsl or {FILES}/cycle.frag or {NUL}; "
            "or add the folder that has it: --include DIR",
        ),
        refused(
            "../secret.frag",
            message="shader '../secret.frag': leads out of the shader folders",
            file="",
            remedy="name a file inside a shader folder, or add its folder: --include DIR",
            name="a path out of the folders",
        ),
    ],
)
