"""Outlines by the stencil buffer: draw an object, mark where it is, draw it larger around the mark.

The boxes are drawn as ever, and wherever they are seen the stencil buffer gets a 1 (REPLACE when
both tests pass). Then each is drawn once more, 1.1 times as large and in one colour, where the
stencil value is not 1 (NOTEQUAL), with the depth test off, so that nothing hides the outline. What
is left of the larger box is what the objects themselves do not cover, pixel for pixel.

Look at: the two boxes and their outlines. The marks are one set: where one box stands before the
other, no line parts them, and an outline runs over the floor alone. It is not equally wide all
around, because a box is scaled about its middle: near corners move further on the screen.
"""

from math import radians

import numpy as np

from shaderlab import (
    Case,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    State,
    Stencil,
    Target,
    exact,
    formula,
    measure,
)
from shaderlab.assets import solids
from shaderlab.glslmath import vec4
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    perspective,
    rotate,
    scale,
    translate,
    world_normal,
)
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.props import tile
from ..scenes.studio import handed_on, softened, studio_color

VIEW = look_at((1.6, 2.1, 4.6), (0.05, 0.25, 0.0))
PROJECTION = perspective(radians(38.0), 16.0 / 9.0, 0.1, 20.0)
COLOR = (0.98, 0.62, 0.12)
GROWN = scale((1.1, 1.1, 1.1))
MODELS = (
    translate((-0.75, 0.55, -0.55)) @ rotate(radians(24.0), (0.0, 1.0, 0.0)),
    translate((0.55, 0.55, 0.35)) @ rotate(radians(-18.0), (0.0, 1.0, 0.0)),
)
BOXES = tuple(
    solids.painted(solids.box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)), color)
    for color in ((0.10, 0.36, 0.42), (0.36, 0.16, 0.30))
)
FLOOR = tile(2.2, 0.5)
JUDGED = (96, 54)


def single(k, model, state):
    """A box in the outline's colour."""
    return Draw(
        vertex="ch03_transforms/studio.vert",
        fragment="ch06_tests/single_color.frag",
        mesh=Mesh(**BOXES[k]),
        uniforms={
            "model": model,
            "normalMatrix": np.linalg.inv(model[:3, :3]).T,
            "view": VIEW,
            "projection": PROJECTION,
            "color": COLOR,
        },
        state=state,
    )


def marked(k):
    """A box as it is, marked with a 1 where it is seen."""
    drawn = stage.prop(BOXES[k], VIEW, PROJECTION, model=MODELS[k])
    stencil = Stencil(func="always", reference=1, depth_pass="replace")
    return Draw(
        vertex=drawn.vertex,
        fragment=drawn.fragment,
        mesh=drawn.mesh,
        uniforms=drawn.uniforms,
        state=State(depth=Depth(), stencil=stencil),
    )


def outlined(k):
    """The larger box around the marks."""
    return single(k, MODELS[k] @ GROWN, State(stencil=Stencil(func="notequal", reference=1)))


def silhouette(name, model):
    """A pass of nothing but the boxes' silhouettes, by no test at all."""
    draws = tuple(single(k, model(k), State()) for k in range(2))
    return Pass(name=name, target=Target(size=JUDGED), draws=draws)


def color_of_outline(color):
    """One colour, opaque."""
    return vec4(color, 1.0)


def reached():
    """What an outline's draw writes wherever it reaches."""
    return 1.0


def wrong(outline, objects, larger):
    """Pixels where the outline is not the larger boxes minus the boxes."""
    return np.count_nonzero((outline == 1.0) != ((larger == 1.0) & (objects == 0.0)))


SETS = {
    "outline": "judged.outline",
    "objects": "objects.outline",
    "larger": "larger.outline",
}

case = Case(
    title="Outlines by the stencil buffer",
    section="6.1.2",
    math=r"\text{outline} = \bigcup_k M_k\,S(1.1)\,B \;\setminus\; \bigcup_k M_k\,B",
    passes=(
        *stage.photographed(
            [
                stage.prop(FLOOR, VIEW, PROJECTION),
                *(marked(k) for k in range(2)),
                *(outlined(k) for k in range(2)),
            ],
            (960, 540),
            depth="depth24_stencil8",
        ),
        Pass(
            name="reordered",
            target=Target(size=JUDGED, depth="depth24_stencil8", clear=stage.SKY),
            draws=(
                marked(1),
                marked(0),
                stage.prop(FLOOR, VIEW, PROJECTION),
                outlined(1),
                outlined(0),
            ),
        ),
        silhouette("objects", lambda k: MODELS[k]),
        silhouette("larger", lambda k: MODELS[k] @ GROWN),
    ),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        *stage.prop_checks(clip_position, world_normal, handed_on, studio_color),
        *(
            formula("judged.FragColor", studio_color, draw=k + 1, name=f"box {k + 1}")
            for k in range(2)
        ),
        *(
            formula("judged.FragColor", color_of_outline, draw=k + 3, name=f"outline {k + 1}")
            for k in range(2)
        ),
        formula("judged.outline", reached, name="where an outline is"),
        formula("judged.gl_Position", clip_position, name="the larger box in clip space"),
        exact(
            "judged.FragColor",
            Output("reordered", "FragColor"),
            name="boxes first, or floor first: the same",
        ),
        measure("pixels where outline ≠ larger − objects", wrong, reads=SETS, equals=0, digits=0),
        measure(
            "pixels of the outline",
            lambda outline: (outline == 1.0).sum(),
            reads={"outline": "judged.outline"},
            at_least=100,
        ),
    ],
)
