"""Six coordinate spaces: where a vertex is on its way from the mesh to the window.

Local: as it was modelled. World: after the model matrix, together with all other objects. View:
seen from the camera, which is the origin and looks down −z. Clip: after the projection, four
numbers, with the distance in w. Device: divided by w, in the cube from −1 to 1, z into the screen.
Window: in pixels, with a depth from 0 to 1. The notes name five; before and after the division by w
are two here. The shader makes the first four and hands over the fourth; the division and the
viewport are the hardware's, worked out here as well so that every step can be seen.

Look at: the aircraft and the golden pyramid of what the camera sees, in all six, from the upper
left. The pyramid comes with the world and is a cube in device coordinates, with the aircraft bent
to match: its near wing is the larger one. In the last field, the cube from the front is the window.

Try: in `ch04_spaces/coordinate_spaces.vert` write `Clip.xyz / 6.0` for `Clip.xyz / Clip.w`: without
the division by w, the pyramid is not bent into a cube.
"""

from math import radians

import numpy as np

from shaderlab import Case, Erratum, assets, formula
from shaderlab.glslmath import mul, swizzle, vec4
from shaderlab.reference.spaces import device, window
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    normal_matrix,
    orthographic,
    perspective,
    scale,
    translate,
    world_normal,
)

from ..scenes import painted_solids as solids, stage
from ..scenes.cameras import camera, turned
from ..scenes.figures import figure
from ..scenes.glm import clip_by_glm
from ..scenes.panels import cell
from ..scenes.props import aircraft, frustum, tile, tripod

MODEL = translate((0.35, 0.45, -0.3)) @ turned(55.0) @ scale(0.95)
CAMERA = camera((1.7, 1.5, 3.0), (0.25, 0.35, -0.3), 40.0, 4.0 / 3.0, near=2.2, far=5.0)
VIEW, PROJECTION = CAMERA["view"], CAMERA["projection"]
NOSE = (0.0, 0.0, -1.0)
BODY = assets.joined(
    solids.painted(solids.box((-0.28, -0.2, 0.0), (0.28, 0.2, 0.5)), solids.INK),
    solids.painted(solids.box((-0.13, -0.13, -0.2), (0.13, 0.13, 0.0)), solids.STONE),
)
# What the camera sees, in the aircraft's own coordinates so that it takes the same way.
FRUSTUM = frustum(PROJECTION @ VIEW @ MODEL, solids.GOLD, 0.02)


def onlooker(eye, target):
    """Where a space is watched from."""
    return perspective(radians(34.0), 4.0 / 3.0, 0.1, 40.0), look_at(eye, target)


def mirrored(projection, view):
    """Left-handed spaces are seen through a mirror in z, so that depth goes away."""
    return projection, view @ scale((1.0, 1.0, -1.0))


WATCHES = {
    "local": onlooker((2.2, 1.7, 3.7), (0.1, 0.15, 0.0)),
    "world": onlooker((-6.0, 5.0, 6.6), (0.3, 0.25, 0.3)),
    "view": onlooker((-6.4, 3.9, 4.4), (0.0, 0.0, -2.1)),
    "clip": mirrored(*onlooker((-11.5, 7.4, 15.0), (0.0, 0.3, -0.7))),
    "device": mirrored(*onlooker((-2.5, 1.9, 4.6), (0.0, 0.0, 0.0))),
    "window": mirrored(orthographic(-40.0, 680.0, -30.0, 510.0, -1.5, 1.5), np.eye(4)),
}
PROPS = {
    "local": (tripod(1.3, 0.03),),
    "world": (tile(2.0, 0.5), tripod(1.0, 0.03), assets.moved(BODY, np.linalg.inv(VIEW))),
    "view": (tripod(1.2, 0.04), BODY),
    "clip": (tripod(2.4, 0.07),),
    "device": (tripod(0.6, 0.025),),
    "window": (),
}


def field(k, space):
    """One field of the picture: the props of a space, the aircraft, and what the camera sees."""
    place = cell(k, 3, 2, from_above=True)
    projection, view = WATCHES[space]
    for solid in PROPS[space]:
        yield stage.prop(solid, {"view": view, "projection": projection}, cell=place)
    for solid in (aircraft(), FRUSTUM)[: 1 if space == "local" else 2]:
        uniforms = {
            "model": MODEL,
            "normalMatrix": normal_matrix(MODEL),
            **CAMERA,
            "viewport": (0.0, 0.0, 640.0, 480.0),
            "space": k,
            "watch": projection @ view,
        }
        yield stage.subject("ch04_spaces/coordinate_spaces.vert", solid, uniforms, cell=place)


DRAWS = [draw for k, space in enumerate(WATCHES) for draw in field(k, space)]
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


def nose(output, reference, equals, name, **inputs):
    """The aircraft's nose after one step."""
    return figure(f"judged.{output}", name, {"aPos": NOSE, **inputs}, equals, reference=reference)


case = Case(
    title="Coordinate spaces",
    section="4.1",
    math=r"\text{local} \xrightarrow{M} \text{world} \xrightarrow{V} \text{view} \xrightarrow{P} "
    r"\text{clip} \xrightarrow{\div w} \text{device} \xrightarrow{\text{viewport}} \text{window}",
    passes=stage.photographed(DRAWS, (1080, 540)),
    picture="picture.FragColor",
    rows=("local, world, view", "clip, device, window"),
    expect=[
        *stage.checks(light=False, edges=0.005),
        formula("judged.World", in_world, name="1 · local to world"),
        formula("judged.View", in_view, name="2 · world to view"),
        formula("judged.Clip", clip_position, also={"PyGLM": clip_by_glm}, name="3 · view to clip"),
        formula("judged.Ndc", in_device, name="4 · clip to device"),
        formula("judged.Window", in_window, name="5 · device to window"),
        *(
            formula("judged.gl_Position", shown(k), draw=FLYING[k], name=f"on show: {name}")
            for k, name in enumerate(WATCHES)
        ),
        formula("judged.Normal", world_normal),
        *stage.color_checks(dict(zip(FLYING, WATCHES, strict=True))),
        nose("World", in_world, (-0.428194, 0.45, -0.844898, 1.0), "the nose in the world"),
        nose("View", in_view, (-0.401702, 0.329822, -4.488296, 1.0), "the nose in view space"),
        nose(
            "Clip",
            clip_position,
            (-0.827751, 0.906179, 3.684190, 4.488296),
            "the nose in clip space",
        ),
        nose("Ndc", in_device, (-0.184424, 0.201898, 0.820844), "the nose in device coordinates"),
        nose("Window", in_window, (260.984225, 288.455576, 0.910422), "the nose in the window"),
        nose(
            "Window",
            in_window,
            (360.984225, 338.455576, 0.910422),
            "the same in a viewport that begins at (100, 50)",
            viewport=(100.0, 50.0, 640.0, 480.0),
        ),
    ],
    errata=[
        Erratum(
            section="4.1",
            says="clip coordinates are brought to −1 … 1",
            truth="device coordinates are, after the division by w; in clip space what is seen has "
            "−w ≤ x, y, z ≤ w, and the nose has a z of 3.68 with a w of 4.49",
            proof="the nose in clip space",
        )
    ],
)
