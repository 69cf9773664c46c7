"""Model, view, projection: three matrices take a vertex from its mesh to the screen.

The model matrix halves the quad and tilts it by −55° around x, the view matrix steps back by three
units, and the perspective matrix has a field of view of 45° from bottom to top. Read the product
from the right: the model acts first. What leaves the vertex shader is still four numbers; the
hardware divides by the last one, w, which is the distance in front of the camera, and so far things
become small.

Look at: the grid's lines. They are parallel on the quad and meet in the distance. The picture shows
a larger quad from the same place; the three matrices are those of the notes.

Try: in `ch03_transforms/mvp.vert` write `model * (view` for `view * (model`: the quad turns around
the camera, not around itself.
"""

from math import radians

import numpy as np

from shaderlab import Case, Depth, Erratum, Mesh, State, Target, assets, formula, mesh_pass, value
from shaderlab.glslmath import abs, fract, min, mix, smoothstep, swizzle, vec3
from shaderlab.reference.transforms import (
    clip_position,
    device_position,
    frustum,
    perspective,
    rotate,
    scale,
    translate,
)

from ..scenes.drawing import chessboard
from ..scenes.laws import opaque, unchanged

# Left, right, bottom, top, near, far: the middle of the window is not straight ahead.
SIX_PLANES = frustum(-1.0, 3.0, -0.5, 1.5, 0.5, 20.0)


def tilted(name, size, pixels):
    """A quad scaled to `size`, tilted away from a camera three units off."""
    return mesh_pass(
        "ch03_transforms/mvp.vert",
        "ch03_transforms/mvp.frag",
        Mesh(**assets.quad()).only("aPos", "aTexCoords"),
        name=name,
        uniforms={
            "model": rotate(radians(-55.0), (1.0, 0.0, 0.0)) @ scale(size),
            "view": translate((0.0, 0.0, -3.0)),
            "projection": perspective(radians(45.0), 4.0 / 3.0, 0.1, 100.0),
        },
        target=Target(size=pixels, depth="depth24", clear=(0.55, 0.65, 0.75, 1.0)),
        state=State(depth=Depth()),
    )


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
    passes=(*tilted("picture", 2.2, (640, 480)), *tilted("half", 0.5, (64, 48))),
    picture="picture.FragColor",
    expect=[
        *(formula(f"{name}.FragColor", opaque(floor_tiles)) for name in ("picture", "half")),
        formula("gl_Position", clip_position),
        formula("Ndc", device_position),
        formula("picture.gl_Position", clip_position),
        formula("TexCoords", unchanged("aTexCoords")),
        value(
            "gl_Position",
            at={"aPos": (0.5, 0.5, 0.0)},
            equals=(0.452665, 0.346184, 3.011004, 3.204788),
            digits=6,
            name="clip coordinates of the corner",
        ),
        *(
            value(
                "gl_Position",
                at={"aPos": place, "model": np.eye(4), "view": np.eye(4), "projection": SIX_PLANES},
                equals=equals,
                digits=6,
                name=f"six planes: {what}",
            )
            for what, place, equals in (
                ("the window's lower left", (-1.0, -0.5, -0.5), (-0.5, -0.5, -0.5, 0.5)),
                ("the window's upper right", (3.0, 1.5, -0.5), (0.5, 0.5, -0.5, 0.5)),
                ("behind it on the far plane", (120.0, 60.0, -20.0), (20.0, 20.0, 20.0, 20.0)),
                ("straight ahead is aside", (0.0, 0.0, -1.0), (-0.5, -0.5, 0.025641, 1.0)),
            )
        ),
        value(
            "Ndc",
            at={"aPos": (0.5, 0.5, 0.0)},
            equals=(0.141246, 0.108021, 0.939533),
            digits=6,
            name="device coordinates of the corner",
        ),
        value(
            "Ndc",
            at={
                "aPos": (0.5, 0.5, 0.0),
                "projection": perspective(radians(45.0), 800 // 600, 0.1, 100.0),
            },
            equals=(0.188329, 0.108021, 0.939533),
            digits=6,
            name=BY_INTEGERS,
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
