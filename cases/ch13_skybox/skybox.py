"""A sky box: a cube around the camera that no step brings nearer.

A sky is so far away that only the camera's turn matters. Of the view matrix, therefore, only the
rotation is kept: its upper left 3 × 3. The box may then be as small as it likes, for its depth is
made the greatest there is: with z = w in clip space the division gives 1. Drawn last with
GL_LEQUAL, it fills just those pixels where nothing else was drawn. A point of the box is at the
same time the direction in which the cube map is read.

Look at: two camera places, some steps apart, under one sky. The crates move against each other and
against the hills; clouds and ridges stand at the very same pixels.
"""

from functools import partial
from math import radians

import numpy as np

from shaderlab import (
    Case,
    Cell,
    CubeTexture,
    Depth,
    Draw,
    Erratum,
    Mesh,
    Output,
    Pass,
    State,
    Target,
    Texture,
    assets,
    exact,
    formula,
    measure,
    value,
)
from shaderlab.glslmath import mul, swizzle, vec4
from shaderlab.reference.spaces import sky_clip
from shaderlab.reference.transforms import clip_position, look_at, perspective, rotate, translate
from shaderlab.sampling import texture

from ..scenes.drawing import decoded
from ..scenes.laws import unchanged
from ..scenes.panels import softened_check, softened_pass
from ..scenes.sky import sky_face
from ..scenes.studio import studio_color

PROJECTION = perspective(radians(50.0), 1.0, 0.1, 100.0)
# The camera looks the same way from both places.
TURN = look_at((0.0, 0.0, 0.0), (0.10, 0.13, -1.0))
HERE, THERE = TURN @ translate((0.0, -0.8, -5.0)), TURN @ translate((-1.5, -1.3, -3.4))
SMOOTH = ("linear", "linear")
MORNING = CubeTexture(faces=[partial(sky_face, k) for k in range(6)], filter=SMOOTH)
NOISE = CubeTexture(faces=list(np.random.default_rng(13).random((6, 8, 8, 4))), filter=SMOOTH)
BOX = Mesh(**assets.cube(2.0)).only("aPos")
CRATE = Texture(image=assets.crate, filter=SMOOTH)
PLAIN = Texture(image=assets.crate(64))
CRATES = [
    translate((-0.9, 0.0, 0.4)) @ rotate(radians(28.0), (0.0, 1.0, 0.0)),
    translate((0.7, 0.0, -2.0)) @ rotate(radians(-20.0), (0.0, 1.0, 0.0)),
    translate((2.4, 0.0, -5.0)) @ rotate(radians(50.0), (0.0, 1.0, 0.0)),
]


def sky(view, faces, vertex="skybox", func="lequal", cell=None):
    """The box around the camera."""
    return Draw(
        vertex=f"ch13_skybox/{vertex}.vert",
        fragment="ch13_skybox/skybox.frag",
        mesh=BOX,
        uniforms={"view": view, "projection": PROJECTION},
        textures={"skybox": faces},
        state=State(depth=Depth(func=func), cell=cell),
    )


def crates(view, wood, cell=None):
    """Three crates on the ground."""
    return [
        Draw(
            vertex="ch04_spaces/ten_cubes.vert",
            fragment="ch04_spaces/ten_cubes.frag",
            mesh=Mesh(**assets.cube()),
            uniforms={"model": model, "view": view, "projection": PROJECTION, "number": 1.0 + k},
            textures={"wood": wood},
            state=State(depth=Depth(), cell=cell),
        )
        for k, model in enumerate(CRATES)
    ]


def alone(name, view, vertex="skybox"):
    """The sky without anything in front of it."""
    return Pass(
        name=name, target=Target(size=(64, 64), depth="depth24"), draws=(sky(view, NOISE, vertex),)
    )


def under(name, *draws):
    """Crates and sky, in one order or the other; the sky writes no number."""
    return Pass(
        name=name,
        target=Target(size=(64, 64), depth="depth24", colors={"FragColor": "rgba32f"}),
        draws=draws,
    )


def along(skybox, TexCoords):
    """The sky in the direction of the box's point."""
    return texture(skybox, TexCoords)


def point(aPos):
    """The box's point is the direction."""
    return aPos


def of_wood(Normal, TexCoords, wood):
    """A crate's texel in the studio's light."""
    color = swizzle(texture(wood, TexCoords), "xyz")
    return studio_color(1.3 * decoded(color), Normal)


def turned_normal(aNormal, model):
    """A normal of a crate that is only turned."""
    return mul(model[:3, :3], aNormal)


def kept_clip(aPos, view, projection):
    """The box's vertex as 7.4.2 has it: moved by the view, too, with z = w."""
    return swizzle(mul(projection, mul(view, vec4(aPos, 1.0))), "xyww")


TEXEL = assets.crate(64)[int(0.3 * 64), int(0.4 * 64), :3].astype(float)
IN_FRONT = np.ravel(studio_color(1.3 * decoded(TEXEL), np.array([0.0, 2.0, 0.0]))).tolist()


def changed(one, other):
    """The share of pixels that two images differ in."""
    return float(np.mean(np.any(one != other, axis=-1)))


HALVES = [Cell(column=k, row=0, columns=2, rows=1) for k in range(2)]

case = Case(
    title="A sky box",
    section="13",
    math=r"\mathbf c = P \begin{pmatrix} V_{3\times3} & 0 \\ 0 & 1 \end{pmatrix} "
    r"\begin{pmatrix} \mathbf p \\ 1 \end{pmatrix}, \qquad "
    r"\mathbf c_{\text{sky}} = (c_x, c_y, c_w, c_w) \;\Rightarrow\; z = 1",
    passes=(
        Pass(
            name="scene",
            target=Target(size=(1536, 768), depth="depth24", colors={"FragColor": "rgba16f"}),
            draws=tuple(
                draw
                for view, cell in zip((HERE, THERE), HALVES, strict=True)
                for draw in (*crates(view, CRATE, cell), sky(view, MORNING, cell=cell))
            ),
        ),
        *softened_pass("scene", (768, 384)),
        alone("here", HERE),
        alone("there", THERE),
        alone("kept-here", HERE, "errata/skybox_kept"),
        alone("kept-there", THERE, "errata/skybox_kept"),
        under("sky-last", *crates(HERE, PLAIN), sky(HERE, NOISE)),
        under("sky-first", sky(HERE, NOISE), *crates(HERE, PLAIN)),
    ),
    picture="picture.FragColor",
    expect=[
        softened_check(),
        formula("here.gl_Position", sky_clip, name="turned, not moved, and z = w"),
        formula("there.gl_Position", sky_clip, name="the same from elsewhere"),
        formula("here.TexCoords", point),
        formula("here.FragColor", along, name="the sky's colours"),
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
        formula("sky-last.FragColor", along, draw=3, name="sky is where nothing else is"),
        formula("sky-last.gl_Position", clip_position, draw=0, name="a crate in clip space"),
        formula("sky-last.Normal", turned_normal, draw=0, name="a crate's normals"),
        formula("sky-last.TexCoords", unchanged("aTexCoords"), draw=0, name="places on its wood"),
        value(
            "sky-last.FragColor",
            draw=0,
            at={"Normal": (0.0, 2.0, 0.0), "TexCoords": (0.4, 0.3)},
            equals=IN_FRONT,
            digits=6,
            reference=of_wood,
            name="a crate under a long normal",
        ),
        formula("kept-here.gl_Position", kept_clip, name="with the translation kept"),
        formula("kept-there.gl_Position", kept_clip, name="with the translation kept, elsewhere"),
        *(
            formula(f"kept-{place}.FragColor", along, name=f"{place}, with the translation kept")
            for place in ("here", "there")
        ),
        formula("kept-here.TexCoords", point, name="directions with the translation kept"),
        exact(
            "sky-first.FragColor",
            Output("sky-last.FragColor"),
            name="sky first or last: the same pixels",
        ),
        exact("sky-first.depth", Output("sky-last.depth"), name="sky first or last: one depth"),
        exact(
            "sky-last.FragColor",
            Output("sky-first.FragColor"),
            name="the order of drawing changes no pixel",
        ),
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
