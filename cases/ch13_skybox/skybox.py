"""A sky box: a cube around the camera that never comes nearer.

A sky is so far away that only the camera's turn matters. Of the view matrix, therefore, only the
rotation is kept: its upper left 3 × 3. The box can then have any size, because its depth is set to
the maximum: with z = w in clip space the division gives 1. Drawn last with GL_LEQUAL, it fills just
those pixels where nothing else was drawn. A point of the box is at the same time the direction in
which the cube map is read.

Look at: two camera places, some steps apart, under one sky. The crates move against each other and
against the hills; clouds and ridges stand at the very same pixels.

Try: in `ch13_skybox/skybox.vert` write `view` for `mat4(mat3(view))`: the box stays among the
crates, and the camera is outside of it.
"""

from math import radians

import numpy as np

from shaderlab import (
    Case,
    Depth,
    Erratum,
    Mesh,
    Output,
    Texture,
    any_order,
    assets,
    exact,
    formula,
    measure,
)
from shaderlab.glslmath import mul, swizzle, vec4
from shaderlab.reference.spaces import sky_clip
from shaderlab.reference.transforms import clip_position, look_at, perspective, translate

from ..scenes import painted_textures
from ..scenes.cameras import turned
from ..scenes.crates import crates, of_wood, turned_normal, wooden
from ..scenes.draws import tested, twins
from ..scenes.figures import figure, figures
from ..scenes.laws import sampled, unchanged
from ..scenes.panel_checks import filled_check, smaller_check, softened_check
from ..scenes.panels import cell, picture, softened_pass
from ..scenes.sky import directions, skies

PROJECTION = perspective(radians(50.0), 1.0, 0.1, 100.0)
# The camera looks the same way from both places.
TURN = look_at((0.0, 0.0, 0.0), (0.10, 0.04, -1.0))
HERE, THERE = TURN @ translate((0.1, -0.8, -6.0)), TURN @ translate((1.0, -2.0, -5.6))
MORNING, NOISE = skies(seed=13)
BOX = Mesh(**assets.cube(2.0)).only("aPos")
CRATE = Texture(image=painted_textures.crate, filter=("linear", "linear"))
PLAIN = Texture(image=painted_textures.crate(64))
CRATES = [
    translate((-0.9, 0.0, 0.4)) @ turned(28.0),
    translate((0.7, 0.0, -2.0)) @ turned(-20.0),
    translate((2.4, 0.0, -5.0)) @ turned(50.0),
]


def sky(view, faces, vertex="skybox", func="lequal", cell=None):
    """The box around the camera."""
    shaders = (f"ch13_skybox/{vertex}.vert", "ch13_skybox/skybox.frag")
    sides, camera = {"skybox": faces}, {"view": view, "projection": PROJECTION}
    return tested(shaders, BOX, camera, textures=sides, depth=Depth(func=func), cell=cell)


def on_the_ground(view, wood, cell=None):
    """Three crates."""
    return crates(CRATES, {"view": view, "projection": PROJECTION}, wood, cell)


def alone(name, view, vertex="skybox"):
    """The sky without anything in front of it."""
    return picture([sky(view, NOISE, vertex)], (64, 64), name, depth="depth24")


def under(name, *draws):
    """Crates and sky, in one order or the other; the sky writes no number."""
    return picture(draws, (64, 64), name, depth="depth24", colors={"FragColor": "rgba32f"})


# The sky in the direction of the box's point.
ALONG = sampled("skybox")


def point(aPos):
    """The box's point is the direction."""
    return aPos


def kept_clip(aPos, view, projection):
    """The box's vertex as 7.4.2 has it: moved by the view, too, with z = w."""
    return swizzle(mul(projection, mul(view, vec4(aPos, 1.0))), "xyww")


TEXEL = painted_textures.crate(64)[int(0.3 * 64), int(0.4 * 64), :3].astype(float)
IN_FRONT = np.ravel(wooden(TEXEL, np.array([0.0, 2.0, 0.0]))).tolist()
# One texel of each face, in the direction from which it is seen.
TEXELS = {
    axis: ({"TexCoords": directions(k, 8)[4, 5]}, NOISE.faces[k][4, 5])
    for k, axis in enumerate(("+x", "−x", "+y", "−y", "+z", "−z"))
}


def changed(one, other):
    """The share of pixels that two images differ in."""
    return float(np.mean(np.any(one != other, axis=-1)))


LONG = {"Normal": (0.0, 2.0, 0.0), "TexCoords": (0.4, 0.3)}


def halves(*size, name):
    """Both places beside each other, from crates of their own: what is uploaded for one pass is not
    what another one is drawn from."""
    draws = [
        draw
        for k, view in enumerate((HERE, THERE))
        for draw in (*on_the_ground(view, CRATE, cell(k, 2)), sky(view, MORNING, cell=cell(k, 2)))
    ]
    return picture(draws, size, name, depth="depth24", colors={"FragColor": "rgba16f"})


SAME_PIXELS = "sky first or last: the same pixels"
SAME_AGAIN = "the order of drawing changes no pixel"

case = Case(
    title="A sky box",
    section="13",
    math=r"\mathbf c = P \begin{pmatrix} V_{3\times3} & 0 \\ 0 & 1 \end{pmatrix} "
    r"\begin{pmatrix} \mathbf p \\ 1 \end{pmatrix}, \qquad "
    r"\mathbf c_{\text{sky}} = (c_x, c_y, c_w, c_w) \;\Rightarrow\; z = 1",
    passes=(
        *twins(halves(1536, 768, name="scene")),
        halves(192, 96, name="judged"),
        *softened_pass("scene", (768, 384)),
        alone("here", HERE),
        alone("there", THERE),
        alone("kept-here", HERE, "errata/skybox_kept"),
        alone("kept-there", THERE, "errata/skybox_kept"),
        under("sky-last", *on_the_ground(HERE, PLAIN), sky(HERE, NOISE)),
        under("sky-first", sky(HERE, NOISE), *on_the_ground(HERE, PLAIN)),
    ),
    picture="picture.FragColor",
    columns=("here", "some steps on"),
    expect=[
        softened_check(),
        any_order("scene.FragColor"),
        smaller_check(edges=0.002),  # joints of planks are thinner than a small pixel
        filled_check("scene"),
        formula("here.gl_Position", sky_clip, name="turned, not moved, and z = w"),
        formula("there.gl_Position", sky_clip, name="the same from elsewhere"),
        formula("here.TexCoords", point),
        formula("here.FragColor", ALONG, name="the sky's colours"),
        *figures("here.FragColor", {f"a texel towards {k}": row for k, row in TEXELS.items()}),
        exact("here.depth", 1.0, name="the sky's depth is 1"),
        exact("there.depth", 1.0, name="and 1 from elsewhere"),
        exact("there.FragColor", Output("here.FragColor"), name="a step changes no pixel"),
        measure(
            "pixels that a step changes, with the translation kept",
            changed,
            reads={"one": "kept-here.FragColor", "other": "kept-there.FragColor"},
            at_least=0.2,  # no formula's: far from none, as a step changes what all pixels show
        ),
        formula("sky-last.FragColor", of_wood, draw=0, name="the first crate is in front"),
        formula("sky-last.FragColor", of_wood, draw=1, name="the second crate is in front"),
        formula("sky-last.FragColor", ALONG, draw=3, name="sky is where nothing else is"),
        formula("sky-last.gl_Position", clip_position, draw=0, name="a crate in clip space"),
        formula("sky-last.Normal", turned_normal, draw=0, name="a crate's normals"),
        formula("sky-last.TexCoords", unchanged("aTexCoords"), draw=0, name="places on its wood"),
        figure("sky-last.FragColor", "a crate under a long normal", LONG, IN_FRONT, draw=0),
        formula("kept-here.gl_Position", kept_clip, name="with the translation kept"),
        formula("kept-there.gl_Position", kept_clip, name="with the translation kept, elsewhere"),
        *(
            formula(f"kept-{place}.FragColor", ALONG, name=f"{place}, with the translation kept")
            for place in ("here", "there")
        ),
        formula("kept-here.TexCoords", point, name="directions with the translation kept"),
        exact("sky-first.FragColor", Output("sky-last.FragColor"), name=SAME_PIXELS),
        exact("sky-first.depth", Output("sky-last.depth"), name="sky first or last: one depth"),
        exact("sky-last.FragColor", Output("sky-first.FragColor"), name=SAME_AGAIN),
        exact("sky-last.depth", Output("sky-first.depth"), name="nor any depth"),
    ],
    errata=[
        Erratum(
            section="7.4.2",
            says="the sky box is drawn with the view matrix as it is",
            truth="its translation has to go, or the sky moves with each step and the camera can "
            "leave the box",
            proof="pixels that a step changes, with the translation kept",
        )
    ],
)
