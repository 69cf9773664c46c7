"""Clipping: of every primitive only what lies in −w ≤ x, y, z ≤ w is drawn.

A vertex shader may put a corner anywhere. Before the division by w, each primitive is cut at the
six planes of the clip volume, and what remains may have more corners than before; a primitive that
lies outside as a whole is dropped. So nothing is drawn beside the viewport, without any scissor
test, and nothing before the near or behind the far plane. It is w that coordinates are held
against: with w = 2, x = 1.6 lies inside.

Look at: the three windows. The grey of each is a square three times as wide, cut to it. On the left
a triangle whose three corners are outside, a hexagon now. In the middle a strip that comes from
before the near plane, light, and goes behind the far one, dark: five eighths are left on either
side. On the right a triangle as large as the first, whose corners have w = 2.
"""

import numpy as np

from shaderlab import Case, Draw, Mesh, Pass, State, Target, coverage, formula, gl_call, measure
from shaderlab.glslmath import mix, swizzle, vec4

from ..scenes.figures import each_draw, figure

SIDE, MARGIN = 160, 20
PAPER = (0.10, 0.11, 0.14, 1.0)
GREY = ((0.80, 0.81, 0.80),) * 2
WARM, COLD = ((0.98, 0.72, 0.28), (0.86, 0.30, 0.16)), ((0.96, 0.93, 0.75), (0.05, 0.16, 0.36))
WIDE = [(-3.0, -3.0, 0.5, 1.0), (3.0, -3.0, 0.5, 1.0), (-3.0, 3.0, 0.5, 1.0), (3.0, 3.0, 0.5, 1.0)]
CUT = [(-1.6, -0.7, 0.0, 1.0), (1.6, -0.7, 0.0, 1.0), (0.0, 1.5, 0.0, 1.0)]
# Depth is 1.6 x: of −0.9…0.9 the middle from −0.625 to 0.625 is left.
STRIP = [(x, y, 1.6 * x, 1.0) for y in (-0.6, 0.6) for x in (-0.9, 0.9)]
HALF = [(x, y, z, 2.0) for x, y, z, _ in CUT]


def drawn(k, corners, colors):
    """A primitive in the k-th window."""
    return Draw(
        vertex="ch02_basics/clipping.vert",
        fragment="ch02_basics/clipping.frag",
        mesh=Mesh(attributes={"aPos": np.array(corners)}, primitive="triangle_strip"),
        uniforms={"nearColor": colors[0], "farColor": colors[1]},
        state=State(viewport=(MARGIN + k * (SIDE + MARGIN), MARGIN, SIDE, SIDE)),
    )


def by_depth(place, nearColor, farColor):
    """From the colour at the near plane to the one at the far plane."""
    depth = swizzle(place, "z") / swizzle(place, "w")
    return vec4(mix(nearColor, farColor, 0.5 + 0.5 * depth), 1.0)


def as_it_is(aPos):
    """Corners are clip coordinates already."""
    return aPos


def inside(corners):
    """Which pixel centres of a window lie in a triangle, counter-clockwise in clip space."""
    centres = np.stack(np.meshgrid(*[(np.arange(SIDE) + 0.5) / (SIDE / 2) - 1.0] * 2), axis=-1)
    points = np.array(corners)[:, :2] / np.array(corners)[:, 3:]
    found = np.ones((SIDE, SIDE), bool)
    for one, other in zip(points, np.roll(points, -1, axis=0), strict=True):
        along, to = other - one, centres - one
        found &= along[0] * to[..., 1] - along[1] * to[..., 0] > 0.0
    return found


def left_of_strip():
    """Which pixels of a window the strip keeps: 0.625 and 0.6 of the way to the edges."""
    found = np.zeros((SIDE, SIDE), bool)
    found[32:128, 30:130] = True
    return found


def window(FragColor, k):
    """The pixels of the k-th window."""
    left = MARGIN + k * (SIDE + MARGIN)
    return FragColor[MARGIN : MARGIN + SIDE, left : left + SIDE]


def elsewhere(FragColor):
    """How many pixels of the windows are grey where a shape is left, or the other way round."""
    drawn = [(window(FragColor, k)[..., :3] != np.float32(GREY[0])).any(axis=-1) for k in range(3)]
    return int(sum((one != other).sum() for one, other in zip(drawn, LEFT, strict=True)))


def beside(FragColor):
    """How many pixels outside of all windows are not as they were cleared."""
    outside = np.ones(FragColor.shape[:2], bool)
    for k in range(3):
        window(outside, k)[:] = False
    return int((FragColor[outside] != np.float32(PAPER)).any(axis=-1).sum())


SHAPES = ((CUT, WARM), (STRIP, COLD), (HALF, WARM))
LEFT = (inside(CUT), left_of_strip(), inside(HALF))
NAMES = ("cut at the sides", "cut at the near and the far plane", "of w = 2, not cut")

case = Case(
    title="Clipping",
    section="2.2.5",
    math=r"-w \le x \le w, \qquad -w \le y \le w, \qquad -w \le z \le w",
    passes=[
        Pass(
            target=Target(size=(3 * SIDE + 4 * MARGIN, SIDE + 2 * MARGIN), clear=PAPER),
            draws=[
                drawn(k, corners, colors)
                for k, shape in enumerate(SHAPES)
                for corners, colors in ((WIDE, GREY), shape)
            ],
        )
    ],
    expect=[
        measure("pixels beside the windows", beside, equals=0, digits=0),
        measure("pixels of the windows that are another's", elsewhere, equals=0, digits=0),
        *(
            coverage(int(left.sum()), draw=2 * k + 1, name=f"pixels, {NAMES[k]}")
            for k, left in enumerate(LEFT)
        ),
        formula("place", as_it_is, name="what is handed on"),
        *each_draw("FragColor", by_depth, {2 * k + 1: name for k, name in enumerate(NAMES)}),
        *each_draw("FragColor", by_depth, {2 * k: f"window {k + 1}" for k in range(3)}),
        *(formula("gl_Position", as_it_is, draw=k, name=f"corners, draw {k}") for k in range(6)),
        figure(
            "FragColor",
            "a quarter of the way from the far plane",
            {
                "place": (0.0, 0.0, 1.0, 2.0),
                "nearColor": (1.0, 0.5, 0.0),
                "farColor": (0.0, 0.5, 1.0),
            },
            (0.25, 0.5, 0.75, 1.0),
            reference=by_depth,
            draw=5,
        ),
        gl_call(
            "glGetIntegerv", "GL_MAX_CLIP_DISTANCES", at_least=8, name="eight planes of one's own"
        ),
    ],
)
