"""A camera on a circle: only the view matrix changes from one frame to the next.

The eye is at (r sin α, h, r cos α), the target stays, and the view matrix of the two is made anew
in each frame. Nothing in the world moves. That its picture turns the other way is the same matrix
read twice: a camera that goes round to the right sees the world go round to the left.

Look at: the strip, row by row from the upper left, twelve frames 30° apart. The letters are read
from the front in the first and from behind in the seventh; the light stays where it is in the
world, so the side that is lit comes and goes.
"""

from math import hypot, radians

import numpy as np

from shaderlab import Case, Cell, Depth, Draw, Mesh, State, assets, computed, formula, sweep, value
from shaderlab.assets import solids
from shaderlab.assets.order import any_order
from shaderlab.glslmath import mul, vec3, vec4
from shaderlab.reference.spaces import in_camera, orbit_eye
from shaderlab.reference.transforms import perspective, rotate, translate
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.props import letter_f, tile
from ..scenes.studio import handed_on, softened, studio_color

FRAMES = 12
RADIUS, HEIGHT = 4.6, 2.0
MIDDLE = (0.0, 0.4, 0.0)
PROJECTION = perspective(radians(34.0), 4.0 / 3.0, 0.1, 20.0)


def still_life():
    """What the camera goes around: a letter, a ball, a ring and a box on a floor."""
    return solids.gathered(
        tile(1.5, 0.5),
        solids.placed(letter_f(), translate((-0.35, 0.0, 0.0))),
        solids.placed(
            solids.painted(assets.sphere(0.32, 32, 16), solids.GOLD), translate((0.85, 0.32, -0.5))
        ),
        solids.placed(
            solids.painted(assets.torus(0.3, 0.1, 40, 16), solids.BLUE), translate((0.7, 0.1, 0.75))
        ),
        solids.placed(
            solids.painted(solids.box((-0.2, 0.0, -0.2), (0.2, 0.4, 0.2)), solids.RED),
            translate((-0.9, 0.0, -0.7)) @ rotate(radians(30.0), (0, 1, 0)),
        ),
    )


SCENE = Mesh(**still_life())


def degrees_of(frame):
    """Where the camera is in a frame; GLSL bounds a sine's error from −180° to 180° only."""
    return (360.0 * frame / FRAMES + 180.0) % 360.0 - 180.0


def frame(k):
    """One place on the circle."""
    return Draw(
        vertex="ch04_spaces/camera_orbit.vert",
        fragment="ch03_transforms/studio.frag",
        mesh=SCENE,
        uniforms={
            "angle": radians(degrees_of(k)),
            "radius": RADIUS,
            "height": HEIGHT,
            "projection": PROJECTION,
        },
        state=State(depth=Depth(), cell=Cell(column=k % 4, row=2 - k // 4, columns=4, rows=3)),
    )


def eye(angle, radius, height):
    """Where the camera is."""
    return orbit_eye(angle, radius, height)


def seen(aPos, angle, radius, height):
    """A vertex in the camera's frame."""
    return in_camera(aPos, orbit_eye(angle, radius, height), vec3(*MIDDLE), vec3(0.0, 1.0, 0.0))


def position(aPos, angle, radius, height, projection):
    """Clip coordinates of the vertex."""
    return mul(projection, vec4(seen(aPos, angle, radius, height), 1.0))


def same_normal(aNormal):
    """Normals are the world's, as the light is."""
    return aNormal


def ahead(degrees):
    """Where the target is in the camera's frame: always on the axis, at one distance."""
    return seen(vec3(*MIDDLE), radians(degrees), RADIUS, HEIGHT)


def at_angle(degrees, place):
    """The eye at one angle."""
    return value(
        "judged.Eye",
        at={"aPos": (0, 0, 0), "angle": radians(degrees), "radius": 5.0, "height": 1.0},
        equals=place,
        digits=6,
        reference=eye,
        name=f"the eye at {degrees}°",
    )


case = Case(
    title="A camera in orbit",
    section="4.3",
    math=r"e(\alpha) = (r \sin\alpha,\ h,\ r \cos\alpha), \qquad "
    r"V(\alpha) = \text{lookAt}(e(\alpha), \text{target}, \text{up})",
    passes=stage.photographed([frame(k) for k in range(FRAMES)], (1120, 630)),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        any_order("judged.FragColor"),
        *stage.light_checks(studio_color),
        *(formula("judged.Eye", eye, draw=k, name=f"eye of frame {k}") for k in range(FRAMES)),
        *(
            formula("judged.gl_Position", position, draw=k, name=f"clip coordinates, frame {k}")
            for k in range(0, FRAMES, 3)
        ),
        *(
            formula("judged.FragColor", studio_color, draw=k, name=f"colour, frame {k}")
            for k in range(0, FRAMES, 3)
        ),
        formula("judged.Normal", same_normal),
        formula("judged.Color", handed_on),
        sweep(
            "judged.Eye",
            eye,
            over="angle",
            at={"aPos": (0.0, 0.0, 0.0)},
            values=np.linspace(-np.pi, np.pi, 49)[1:-1],
            name="the circle",
        ),
        value(
            "judged.gl_Position",
            at={
                "aPos": (3.0, 2.0, 1.0),
                "angle": radians(30.0),
                "radius": 0.01,
                "height": MIDDLE[1],
                "projection": np.eye(4),
            },
            equals=(2.098076, 1.6, 2.356025, 1.0),
            digits=6,
            reference=position,
            name="close to the target, without a projection",
            note="so small a circle passes on little of what sine and cosine may err",
        ),
        at_angle(0, (0.0, 1.0, 5.0)),
        at_angle(30, (2.5, 1.0, 4.330127)),
        at_angle(90, (5.0, 1.0, 0.0)),
        *(
            computed(
                f"the target in the camera's frame at {degrees}°",
                lambda degrees=degrees: ahead(degrees),
                equals=(0.0, 0.0, -hypot(RADIUS, HEIGHT - MIDDLE[1])),
                digits=12,
            )
            for degrees in (0, 30, 135)
        ),
    ],
)
