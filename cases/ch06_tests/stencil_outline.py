"""Outlines by the stencil buffer: draw an object, mark where it is, draw it larger around the mark.

The boxes are drawn as usual, and wherever they are visible the stencil buffer gets a 1 (REPLACE
when both tests pass). Then each is drawn once more, 1.1 times as large and in one colour, where the
stencil value is not 1 (NOTEQUAL), with the depth test off, so that nothing hides the outline. What
is left of the larger box is what the objects themselves do not cover, pixel for pixel.

Look at: the two boxes and their outlines. Both boxes share one mark: where one box is in front of
the other, no line separates them, and the outline runs over the floor only. It is not equally wide
all around, because a box is scaled about its middle: near corners move further on the screen.

Try: in `ch06_tests/single_color.frag` write `vec4(color * step(0.5, fract(gl_FragCoord.x / 16.0)),
1.0)` for `vec4(color, 1.0)`: only the outlines are dashed, because only they are drawn by this
shader.
"""

from dataclasses import replace

import numpy as np

from shaderlab import Case, Depth, Pass, State, Stencil, Target, any_order, exact, formula, measure
from shaderlab.reference.transforms import clip_position, scale, translate, world_normal

from ..scenes import painted_solids as solids, stage
from ..scenes.cameras import camera, turned
from ..scenes.draws import twins
from ..scenes.figures import each_draw
from ..scenes.laws import opaque, unchanged
from ..scenes.panels import panel, picture
from ..scenes.props import tile
from ..scenes.studio import handed_on, studio_color

CAMERA = camera((1.6, 2.1, 4.6), (0.05, 0.25, 0.0), 38.0, 16.0 / 9.0)
GROWN, COLOR = scale((1.1, 1.1, 1.1)), opaque(unchanged("color"))
PLACES = translate((-0.75, 0.55, -0.55)), translate((0.55, 0.55, 0.35))
MODELS = PLACES[0] @ turned(24.0), PLACES[1] @ turned(-18.0)
BOX = solids.box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
BOXES = [solids.painted(BOX, color) for color in ((0.10, 0.36, 0.42), (0.36, 0.16, 0.30))]
FLOOR = stage.prop(tile(2.2, 0.5), CAMERA)
JUDGED, ORANGE = (96, 54), (0.98, 0.62, 0.12)


def single(k, model, state):
    """A box in the outline's colour."""
    plain, shader = stage.prop(BOXES[k], CAMERA, model=model), "ch06_tests/single_color.frag"
    return replace(
        plain, fragment=shader, uniforms={**plain.uniforms, "color": ORANGE}, state=state
    )


MARK = Stencil(func="always", reference=1, depth_pass="replace")
AROUND = State(stencil=Stencil(func="notequal", reference=1))
# A box as it is, marked with a 1 where it is seen; then the larger one around the marks.
MARKED = [stage.prop(BOXES[k], CAMERA, model=MODELS[k], stencil=MARK) for k in range(2)]
OUTLINED = [single(k, MODELS[k] @ GROWN, AROUND) for k in range(2)]


def silhouette(name, models):
    """A pass of nothing but the boxes' silhouettes, by no test at all."""
    draws = tuple(single(k, model, State()) for k, model in enumerate(models))
    return Pass(name=name, target=Target(size=JUDGED, colors={"outline": "r32f"}), draws=draws)


def wrong(outline, objects, larger):
    """Pixels where the outline is not the larger boxes minus the boxes."""
    return np.count_nonzero((outline == 1.0) != ((larger == 1.0) & (objects == 0.0)))


SETS = {"outline": "judged.outline", "objects": "objects.outline", "larger": "larger.outline"}
# What hides all, what is hidden and leaves no mark, and the outline's colour over all of it.
SHOWN = {"depth": Depth(func="always")}
HIDDEN = {"depth": Depth(), "depth_range": (0.8, 0.8), "stencil": MARK}
STATES = {(0, 0, 0): SHOWN, (0, 0, 1): HIDDEN, ORANGE: {"stencil": AROUND.stencil}}
FILLED = [panel("ch06_tests/single_color.frag", {}, {"color": c}, **s) for c, s in STATES.items()]
# No formula's: the sets above are not all empty.
SOME = {"reads": {"outline": "judged.outline"}, "at_least": 100}

case = Case(
    title="Outlines by the stencil buffer",
    section="6.1.2",
    math=r"\text{outline} = \bigcup_k M_k\,S(1.1)\,B \;\setminus\; \bigcup_k M_k\,B",
    passes=(
        *stage.photographed(
            [FLOOR, *MARKED, *OUTLINED],
            (960, 540),
            depth="depth24_stencil8",
            reordered=[*MARKED[::-1], FLOOR, *OUTLINED[::-1]],
        ),
        *twins(picture([FLOOR, *MARKED], JUDGED, "boxes", depth="depth24_stencil8")),
        picture(FILLED, (16, 16), "filled", depth="depth24_stencil8"),
        silhouette("objects", MODELS),
        silhouette("larger", [model @ GROWN for model in MODELS]),
    ),
    picture="picture.FragColor",
    expect=[
        *stage.picture_checks("outline", tested=False),
        any_order("boxes.FragColor"),
        *stage.prop_checks(),
        *each_draw("judged.FragColor", studio_color, {1: "box 1", 2: "box 2"}),
        *each_draw("judged.FragColor", COLOR, {3: "outline 1", 4: "outline 2"}),
        exact("filled.FragColor", np.float32((*ORANGE, 1.0)), name="what is hidden has no mark"),
        exact("filled.outline", 1.0, name="and each is marked"),
        *each_draw("judged.Normal", world_normal, {3: "normals 1", 4: "normals 2"}),
        *each_draw("judged.Color", handed_on, {3: "colours 1", 4: "colours 2"}),
        formula("judged.outline", lambda: 1.0, name="where an outline is"),
        formula("judged.gl_Position", clip_position, name="the larger box in clip space"),
        measure("pixels where outline ≠ larger − objects", wrong, reads=SETS, equals=0, digits=0),
        measure("pixels of the outline", lambda outline: (outline == 1.0).sum(), **SOME),
    ],
)
