"""Six coordinate spaces: what a vertex is called on its way from the mesh to the window.

Local: as it was modelled. World: after the model matrix, among other things. View: seen from the
camera, which is the origin and looks down −z. Clip: after the projection, four numbers, with the
distance in w. Device: divided by w, in the cube from −1 to 1, z into the screen. Window: in pixels,
with a depth from 0 to 1. The shader makes the first four and hands over the fourth; the division
and the viewport are the hardware's, worked out here as well so that every step can be seen.

Look at: the aircraft and the golden pyramid of what the camera sees, in all six, from the upper
left. The pyramid comes with the world and is a cube in device coordinates, with the aircraft bent
to match: its near wing is the larger one. In the last field, the cube from the front is the window.
"""

from math import radians

import numpy as np

from shaderlab import Case, Cell, Depth, Draw, Mesh, State, formula, value
from shaderlab.assets import solids
from shaderlab.assets.order import any_order
from shaderlab.glslmath import mul, swizzle, vec4
from shaderlab.reference.spaces import device, window
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    normal_matrix,
    orthographic,
    perspective,
    rotate,
    scale,
    translate,
    world_normal,
)
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.glm import clip_by_glm
from ..scenes.props import aircraft, tile, tripod
from ..scenes.studio import handed_on, softened, studio_color

MODEL = translate((0.35, 0.45, -0.3)) @ rotate(radians(55.0), (0, 1, 0)) @ scale(0.95)
EYE, TARGET = (1.7, 1.5, 3.0), (0.25, 0.35, -0.3)
VIEW = look_at(EYE, TARGET)
PROJECTION = perspective(radians(40.0), 4.0 / 3.0, 2.2, 5.0)
VIEWPORT = (0.0, 0.0, 640.0, 480.0)
NOSE = (0.0, 0.0, -1.0)

AIRCRAFT = aircraft()


def frustum():
    """What the camera sees, in the aircraft's own coordinates so that it takes the same way."""
    corners = [(x, y, z, 1.0) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    seen = (np.linalg.inv(PROJECTION @ VIEW @ MODEL) @ np.array(corners).T).T
    return solids.wire(seen[:, :3] / seen[:, 3:], solids.GOLD, 0.02)


def onlooker(eye, target, reach=1.0, up=(0, 1, 0)):
    """A view of a space `reach` units across, from `eye`."""
    return perspective(radians(34.0), 4.0 / 3.0, 0.1 * reach, 40.0 * reach) @ look_at(
        eye, target, up
    )


# Where each space is watched from; left-handed ones through a mirror in z, so that depth goes away.
MIRROR = scale((1.0, 1.0, -1.0))
WATCHES = (
    onlooker((2.2, 1.7, 3.7), (0.1, 0.15, 0.0)),
    onlooker((-6.0, 5.0, 6.6), (0.3, 0.25, 0.3)),
    onlooker((-6.4, 3.9, 4.4), (0.0, 0.0, -2.1)),
    onlooker((-11.5, 7.4, 15.0), (0.0, 0.3, -0.7)) @ MIRROR,
    onlooker((-2.5, 1.9, 4.6), (0.0, 0.0, 0.0)) @ MIRROR,
    orthographic(-40.0, 680.0, -30.0, 510.0, -1.5, 1.5) @ MIRROR,
)
NAMES = ("local", "world", "view", "clip", "device", "window")


def steps(solid, space, cell):
    """One solid in one of the six spaces."""
    return Draw(
        vertex="ch04_spaces/coordinate_spaces.vert",
        fragment="ch03_transforms/studio.frag",
        mesh=Mesh(**solid),
        uniforms={
            "model": MODEL,
            "normalMatrix": normal_matrix(MODEL),
            "view": VIEW,
            "projection": PROJECTION,
            "viewport": VIEWPORT,
            "space": space,
            "watch": WATCHES[space],
        },
        state=State(depth=Depth(), cell=cell),
    )


def camera():
    """The camera as a box with a lens, in its own coordinates."""
    body = solids.painted(solids.box((-0.28, -0.2, 0.0), (0.28, 0.2, 0.5)), solids.INK)
    lens = solids.painted(solids.box((-0.13, -0.13, -0.2), (0.13, 0.13, 0.0)), solids.STONE)
    return solids.gathered(body, lens)


def field(space):
    """One field of the picture."""
    cell = Cell(column=space % 3, row=1 - space // 3, columns=3, rows=2)
    watch, still = WATCHES[space], np.eye(4)
    props = {
        0: (tripod(1.3, 0.03),),
        1: (
            tile(2.0, 0.5),
            tripod(1.0, 0.03),
            solids.placed(camera(), np.linalg.inv(VIEW)),
        ),
        2: (tripod(1.2, 0.04), camera()),
        3: (tripod(2.4, 0.07),),
        4: (tripod(0.6, 0.025),),
        5: (),
    }[space]
    shapes = (AIRCRAFT,) if space == 0 else (AIRCRAFT, frustum())
    return (
        *(stage.prop(solid, still, watch, cell=cell) for solid in props),
        *(steps(solid, space, cell) for solid in shapes),
    )


FIELDS = [field(space) for space in range(6)]
DRAWS = [draw for draws in FIELDS for draw in draws]
# The aircraft's draw in each field: the first that shows a space.
FLYING = [
    next(k for k, draw in enumerate(DRAWS) if draw.uniforms.get("space") == space)
    for space in range(6)
]


def in_world(aPos, model):
    """Step 1."""
    return mul(model, vec4(aPos, 1.0))


def in_view(aPos, model, view):
    """Step 2."""
    return mul(view, in_world(aPos, model))


def in_device(aPos, model, view, projection):
    """Step 4."""
    return device(clip_position(aPos, model, view, projection))


def in_window(aPos, model, view, projection, viewport):
    """Step 5."""
    return window(in_device(aPos, model, view, projection), viewport, np.array([0.0, 1.0]))


def shown(space):
    """Where the onlooker of a space sees a vertex."""

    def position(aPos, model, view, projection, viewport, watch):
        places = (
            aPos,
            swizzle(in_world(aPos, model), "xyz"),
            swizzle(in_view(aPos, model, view), "xyz"),
            swizzle(clip_position(aPos, model, view, projection), "xyz"),
            in_device(aPos, model, view, projection),
            in_window(aPos, model, view, projection, viewport),
        )
        return mul(watch, vec4(places[space], 1.0))

    return position


def nose(output, reference, equals, name):
    """The aircraft's nose after one step."""
    return value(
        f"judged.{output}",
        at={"aPos": NOSE},
        equals=equals,
        digits=6,
        reference=reference,
        name=name,
    )


case = Case(
    title="Coordinate spaces",
    section="4.1",
    math=r"\text{local} \xrightarrow{M} \text{world} \xrightarrow{V} \text{view} \xrightarrow{P} "
    r"\text{clip} \xrightarrow{\div w} \text{device} \xrightarrow{\text{viewport}} \text{window}",
    passes=stage.photographed(DRAWS, (1080, 540)),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        any_order("judged.FragColor"),
        *stage.prop_checks(clip_position, world_normal, handed_on, studio_color),
        formula("judged.World", in_world, name="1 · local to world"),
        formula("judged.View", in_view, name="2 · world to view"),
        formula("judged.Clip", clip_position, also={"PyGLM": clip_by_glm}, name="3 · view to clip"),
        formula("judged.Ndc", in_device, name="4 · clip to device"),
        formula("judged.Window", in_window, name="5 · device to window"),
        *(
            formula("judged.gl_Position", shown(k), draw=FLYING[k], name=f"on show: {name}")
            for k, name in enumerate(NAMES)
        ),
        formula("judged.Normal", world_normal),
        formula("judged.Color", handed_on),
        *(
            formula("judged.FragColor", studio_color, draw=FLYING[k], name=f"colour, {name}")
            for k, name in enumerate(NAMES)
        ),
        nose(
            "World", in_world, (-0.428194, 0.450000, -0.844898, 1.000000), "the nose in the world"
        ),
        nose("View", in_view, (-0.401702, 0.329822, -4.488296, 1.000000), "the nose in view space"),
        nose(
            "Clip",
            clip_position,
            (-0.827751, 0.906179, 3.684190, 4.488296),
            "the nose in clip space",
        ),
        nose("Ndc", in_device, (-0.184424, 0.201898, 0.820844), "the nose in device coordinates"),
        nose("Window", in_window, (260.984225, 288.455576, 0.910422), "the nose in the window"),
    ],
)
