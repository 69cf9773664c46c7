"""Model, view, projection: three matrices take a vertex from its mesh to the screen.

The model matrix halves the quad and tilts it by −55° around x, the view matrix steps back by three
units, and the perspective matrix has a field of view of 45° from bottom to top. Read the product
from the right: the model acts first. The hardware divides what leaves the vertex shader by w, the
distance in front of the camera, and so far things become small.

Look at: the grid's lines. They are parallel on the quad and meet in the distance. The picture shows
a larger quad from the same place; the three matrices are those of the notes.

Try: in `ch03_transforms/mvp.vert` write `(transpose(model)` for `(model`: a rotation's transpose
turns the other way, and the grid hangs overhead, like a ceiling.
"""

from math import radians

import numpy as np

from shaderlab import Case, Erratum, assets, formula
from shaderlab.glslmath import abs, fract, min, mix, smoothstep, swizzle, vec3
from shaderlab.reference.transforms import (
    clip_position,
    device_position,
    frustum,
    perspective,
    scale,
    translate,
)

from ..scenes.cameras import turned
from ..scenes.drawing import chessboard
from ..scenes.draws import tested
from ..scenes.figures import figures
from ..scenes.laws import opaque, unchanged
from ..scenes.panels import picture

# Left, right, bottom, top, near, far: the middle of the window is not straight ahead.
SIX_PLANES = {"projection": frustum(-1.0, 3.0, -0.5, 1.5, 0.5, 20.0)}
SIX = {
    f"six planes: {what}": ({"aPos": place, **SIX_PLANES}, clip)
    for what, place, clip in (
        ("the window's lower left", (-1.0, -0.5, -0.5), (-0.5, -0.5, -0.5, 0.5)),
        ("the window's upper right", (3.0, 1.5, -0.5), (0.5, 0.5, -0.5, 0.5)),
        ("behind it on the far plane", (120.0, 60.0, -20.0), (20.0, 20.0, 20.0, 20.0)),
        ("straight ahead is aside", (0.0, 0.0, -1.0), (-0.5, -0.5, 0.025641, 1.0)),
    )
}
CORNER, CLIP = {"aPos": (0.5, 0.5, 0.0)}, (0.452665, 0.346184, 3.011004, 3.204788)


def seen(aspect):
    """The view of 45°, from 0.1 to 100 units away."""
    return perspective(radians(45.0), aspect, 0.1, 100.0)


def tilted(name, size, pixels):
    """A quad scaled to `size`, tilted away from a camera three units off."""
    model = turned(-55.0, (1.0, 0.0, 0.0)) @ scale(size)
    camera = {"view": translate((0.0, 0.0, -3.0)), "projection": seen(4.0 / 3.0)}
    uniforms, only = {"model": model, **camera}, ("aPos", "aTexCoords")
    quad = tested("ch03_transforms/mvp", assets.quad(), uniforms, only=only)
    return picture([quad], pixels, name, depth="depth24", clear=(0.55, 0.65, 0.75, 1.0))


def floor_tiles(TexCoords, frag_coord):
    """Fields, the lines between them, and the air before what is far away; w is 1 / distance."""
    place, away = 8.0 * TexCoords, 1.0 / swizzle(frag_coord, "w")
    color = mix(vec3(0.16, 0.22, 0.30), vec3(0.86, 0.80, 0.68), chessboard(place))
    off = abs(fract(place + 0.5) - 0.5)
    to_line = min(swizzle(off, "x"), swizzle(off, "y"))
    color = mix(vec3(0.95, 0.55, 0.20), color, smoothstep(0.004 * away, 0.012 * away, to_line))
    return mix(color, vec3(0.55, 0.65, 0.75), 0.6 * ((away - 2.1) / 1.8))


BY_INTEGERS = "the corner, where 800 / 600 is divided as integers: x is a third too large"

case = Case(
    title="Model, view, projection",
    section="3.4",
    math=r"\mathbf{c} = P\,V\,M\,(x, y, z, 1)^{\mathsf T}, \qquad "
    r"\mathbf{n} = (c_x, c_y, c_z)\,/\,c_w",
    passes=(tilted("picture", 2.2, (640, 480)), tilted("half", 0.5, (64, 48))),
    picture="picture.FragColor",
    expect=[
        *(formula(f"{name}.FragColor", opaque(floor_tiles)) for name in ("picture", "half")),
        formula("gl_Position", clip_position),
        formula("Ndc", device_position),
        formula("picture.gl_Position", clip_position),
        formula("TexCoords", unchanged("aTexCoords")),
        *figures("gl_Position", {"clip coordinates of the corner": (CORNER, CLIP)}),
        *figures("gl_Position", SIX, at={"model": np.eye(4), "view": np.eye(4)}),
        *figures(
            "Ndc",
            {
                "device coordinates of the corner": ({}, (0.141246, 0.108021, 0.939533)),
                BY_INTEGERS: ({"projection": seen(800 // 600)}, (0.188329, 0.108021, 0.939533)),
            },
            at=CORNER,
        ),
    ],
    errata=[
        Erratum(
            section="3.4",
            says="the aspect ratio is the width divided by the height, which are integers",
            truth="in C++ the quotient of two integers is an integer: 800 / 600 is 1, and what "
            "is seen is a third too wide; one of the two has to be a float",
            proof=BY_INTEGERS,
        )
    ],
)
