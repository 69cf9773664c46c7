"""Clipping: only the part of a primitive with −w ≤ x, y, z ≤ w is drawn.

A vertex shader may put a corner anywhere. Before the division by w, each primitive is cut at the
six planes of the clip volume. What remains may have more corners than before, and a primitive that
lies wholly outside is dropped. So nothing is drawn outside the viewport, even without a scissor
test, and nothing in front of the near plane or behind the far plane. Coordinates are compared with
w: with w = 2, x = 1.6 lies inside.

Look at: the three windows. Each is filled by a grey square three times as wide, cut to fit. On the
left, a triangle with all three corners outside has become a hexagon. In the middle, a strip runs
from in front of the near plane (light) to behind the far one (dark), and five eighths of it remain.
On the right is a triangle as large as the first, whose corners have w = 2.

Try: in `ch02_basics/clipping.vert` write `gl_Position = vec4(aPos.xyz, 2.0 * aPos.w)` for
`gl_Position = aPos`: everything is half as large, and the hexagon gets its three corners back where
there is room.
"""

import numpy as np

from shaderlab import Case, Draw, Mesh, Pass, State, Target, formula, gl_call, measure
from shaderlab.glslmath import mix, swizzle, vec4
from shaderlab.reference.rasterisation import barycentric

from ..scenes.figures import each_draw, figure
from ..scenes.laws import unchanged

SIDE, MARGIN = 160, 20
PAPER, GREY = (0.10, 0.11, 0.14, 1.0), ((0.80, 0.81, 0.80),) * 2
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


def inside(corners):
    """Which pixel centres of a window lie in a triangle."""
    centres = np.stack(np.meshgrid(*[(np.arange(SIDE) + 0.5) / (SIDE / 2) - 1.0] * 2), axis=-1)
    points = np.array(corners)[:, :2] / np.array(corners)[:, 3:]
    return (barycentric(centres, points) > 0.0).all(axis=-1)


def elsewhere(FragColor):
    """How many pixels show paper, a window's grey or its shape where another of them should be."""
    paper, grey = ((FragColor == np.float32(c)).all(axis=-1) for c in (PAPER, (*GREY[0], 1.0)))
    return np.count_nonzero(np.where(paper, 0, np.where(grey, 1, 2)) != SEEN)


SHAPES = {
    "cut at the sides": (CUT, WARM),
    "cut at the near and the far plane": (STRIP, COLD),
    "of w = 2, not cut": (HALF, WARM),
}
# What is seen at each pixel: 0 the paper, 1 a window's grey, 2 what is left of its shape. The strip
# keeps 0.625 of the way to either side, and is 0.6 of it high.
LEFT = (inside(CUT), np.pad(np.ones((96, 100), bool), ((32, 32), (30, 30))), inside(HALF))
SEEN = np.pad(
    np.concatenate([np.pad(1 + left, ((0, 0), (0, MARGIN))) for left in LEFT], axis=1),
    ((MARGIN, MARGIN), (MARGIN, 0)),
)
QUARTER = "a quarter of the way from the far plane"
ON_THE_WAY = {"place": (0, 0, 1, 2), "nearColor": (1.0, 0.5, 0.0), "farColor": (0.0, 0.5, 1.0)}
DRAWN = [name for k, shape in enumerate(SHAPES) for name in (f"window {k + 1}", shape)]

case = Case(
    title="Clipping",
    section="2.2.5",
    math=r"-w \le x \le w, \qquad -w \le y \le w, \qquad -w \le z \le w",
    passes=[
        Pass(
            target=Target(size=(3 * SIDE + 4 * MARGIN, SIDE + 2 * MARGIN), clear=PAPER),
            draws=[
                drawn(k, corners, colors)
                for k, shape in enumerate(SHAPES.values())
                for corners, colors in ((WIDE, GREY), shape)
            ],
        )
    ],
    expect=[
        measure("pixels that show something else", elsewhere, equals=0, digits=0),
        formula("place", unchanged("aPos"), name="what is handed on"),
        *each_draw("FragColor", by_depth, enumerate(DRAWN)),
        *(
            formula("gl_Position", unchanged("aPos"), draw=k, name=f"corners, {name}")
            for k, name in enumerate(DRAWN)
        ),
        figure("FragColor", QUARTER, ON_THE_WAY, (0.25, 0.5, 0.75, 1.0)),
        gl_call("glGetIntegerv", "GL_MAX_CLIP_DISTANCES", at_least=8, name="eight planes more"),
    ],
)
