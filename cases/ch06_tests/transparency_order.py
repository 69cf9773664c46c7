"""Transparent things: draw them from far to near, or blending gives another colour.

The operator *over* is not commutative: red over blue is not blue over red. Seen through three panes
the colour is C₃ over (C₂ over (C₁ over background)), with C₁ the farthest, and blending computes
just that if the farthest is drawn first. Opaque things are drawn first, with the depth test and its
mask on; the panes are tested, so that opaque things hide them, but write no depth.

Look at: three discs of glass before a wall, red the farthest, blue the nearest, and a dark disc
that stands between green and blue. On the left they are drawn from far to near. In the middle they
are drawn from near to far, and where all three overlap, red seems to lie in front. On the right
they are drawn from near to far and write their depth: nothing behind a pane is visible.

Try: in `ch06_tests/glass.frag` write `FragColor = vec4(color.rgb, 1.0)` for `FragColor = color`:
opaque discs need no order where the depth is written: the right panel looks like the left one.
"""

import numpy as np

from shaderlab import (
    Blend,
    Case,
    Depth,
    Output,
    Pass,
    Pixel,
    Target,
    boundaries,
    computed,
    formula,
    measure,
    value,
)
from shaderlab.glslmath import dot, max, min, swizzle, vec3, vec4, where
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.blending import over

from ..scenes.figures import figure
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, panel, picture, square

OVER = Blend(source="src_alpha", destination="one_minus_src_alpha")
WALL = (0.90, 0.88, 0.82, 1.0)
DARK, DARK_DEPTH = (0.16, 0.18, 0.22, 1.0), 0.4
# From far to near: centre, colour and α, depth.
PANES = (
    ((-0.26, -0.20), (0.90, 0.15, 0.10, 0.6), 0.7),
    ((0.26, -0.20), (0.15, 0.75, 0.25, 0.45), 0.5),
    ((0.0, 0.26), (0.15, 0.30, 0.95, 0.4), 0.3),
)
RADIUS = 0.55
DARK_CENTRE, DARK_RADIUS = (0.62, 0.50), 0.3
SIZES = {"judged": 72.0, "seen": 360.0}
WAYS = ("sorted", "reversed", "written")


def disc(centre, radius, color, depth, state):
    """A disc at one depth."""
    uniforms = {"centre": centre, "radius": radius, "color": color}
    state = {"depth_range": (depth, depth), **state}
    return panel("ch06_tests/glass.frag", {"place": square()}, uniforms, **state)


def opaque():
    """The wall behind everything, and what stands between the panes."""
    depth = {"depth": Depth()}
    return (
        disc((0.0, 0.0), 2.0, WALL, 0.9, depth),
        disc(DARK_CENTRE, DARK_RADIUS, DARK, DARK_DEPTH, depth),
    )


def panes(order, write=False):
    """The panes in an order, blended."""
    state = {"depth": Depth(write=write), "blend": OVER}
    return tuple(disc(c, RADIUS, color, depth, state) for c, color, depth in order)


def scene(name, drawn, size):
    """Opaque things, then the panes."""
    return Pass(
        name=name,
        target=Target(size=(int(size), int(size)), depth="depth24"),
        draws=(*opaque(), *drawn),
    )


def scenes(kind, size):
    """The three ways to draw them."""
    return (
        scene(f"{kind}_sorted", panes(PANES), size),
        scene(f"{kind}_reversed", panes(PANES[::-1]), size),
        scene(f"{kind}_written", panes(PANES[::-1], write=True), size),
    )


def shown(name, kind):
    """The three ways side by side, each in a frame."""
    side = int(SIZES[kind])
    panels = (
        panel(
            "ch06_tests/transparency_order.frag",
            {"at": square(0.0, 1.0)},
            textures={"scene": Output(f"{kind}_{way}.FragColor")},
            cell=cell(k, 3),
        )
        for k, way in enumerate(WAYS)
    )
    return picture(panels, (3 * side, side), name)


def inside(place, centre, radius):
    """Whether a place lies in a disc."""
    away = place - np.array(centre)
    return dot(away, away) <= radius * radius


def layered(at, order, hides):
    """Wall, dark disc, and the panes over them in an order; with `hides`, only the first one."""
    place = 2.0 * at - 1.0
    dark = inside(place, DARK_CENTRE, DARK_RADIUS)
    color = where(dark, vec4(*DARK), vec4(*WALL))
    free = where(dark, DARK_DEPTH, 1.0)
    for centre, pane, depth in order:
        seen = where(depth < free, where(inside(place, centre, RADIUS), 1.0, 0.0), 0.0)
        color = where(seen > 0.5, over(vec4(*pane), color), color)
        free = where(seen > 0.5, depth, free) if hides else free
    return color


def in_frame(at, color):
    """A colour, or the frame's."""
    x, y = swizzle(at, "x"), swizzle(at, "y")
    frame = (min(x, y) < 0.01) | (max(x, y) > 0.99)
    return vec4(where(frame, vec3(0.97), swizzle(color, "rgb")), 1.0)


def framed(order, hides):
    """What `layered` gives, in a frame."""
    return lambda at: in_frame(at, layered(at, order, hides))


def framed_texel(at, scene):
    """What was drawn, in a frame."""
    return in_frame(at, texture(scene, at))


def outside(place, centre, radius):
    """What is thrown away of a disc's square."""
    away = place - centre
    return dot(away, away) > radius * radius


def own_color(color):
    """A pane's colour before it is blended."""
    return color


def stack(order):
    """The colour of all panes before the wall."""
    color = np.array(WALL)
    for _, pane, _ in order:
        color = over(np.array(pane), color)
    return color


def order_error(right, other):
    """The largest difference of a channel."""
    return np.abs(right[..., :3] - other[..., :3]).max()


MIDDLE = Pixel(36, 34)

case = Case(
    title="Transparent things in order",
    section="6.3",
    math=r"C = C_3 \mathbin{\text{over}} (C_2 \mathbin{\text{over}} (C_1 "
    r"\mathbin{\text{over}} B)), \qquad S \mathbin{\text{over}} D = \alpha S + (1 - \alpha) D",
    passes=(
        *scenes("judged", SIZES["judged"]),
        *scenes("seen", SIZES["seen"]),
        shown("picture", "seen"),
        shown("small", "judged"),
    ),
    picture="picture.FragColor",
    columns=("far to near", "near to far", "near to far, depth written"),
    expect=[
        *(
            formula("small.FragColor", framed(order, hides), draw=k, name=name)
            for k, (order, hides, name) in enumerate(
                (
                    (PANES, False, "far to near is over, over, over"),
                    (PANES[::-1], False, "near to far"),
                    (PANES[::-1], True, "near to far, depth written"),
                )
            )
        ),
        enlarged_check(),
        figure("small.FragColor", "beside the frame", {"at": (0.985, 0.5)}, WALL, draw=0,
               reference=framed_texel),
        boundaries("small.FragColor", framed_texel, draw=0, name="the frame"),
        value("judged_sorted.FragColor", at=MIDDLE, equals=(0.3975, 0.46836, 0.57554, 0.5323),
              digits=6, name="behind all three panes, far to near"),
        value("judged_reversed.FragColor", at=MIDDLE, equals=(0.699, 0.36756, 0.29684, 0.6082),
              digits=6, name="behind all three panes, near to far"),
        value("judged_sorted.FragColor", at={"place": (RADIUS, PANES[2][0][1])},
              equals=PANES[2][1], digits=6, reference=own_color, draw=4, discards=outside,
              name="a disc has its rim"),
        computed("all three, far to near", lambda: stack(PANES), digits=6,
                 equals=(0.3975, 0.46836, 0.57554, 0.5323)),
        measure(
            "error of the order",
            order_error,
            reads={"right": "judged_sorted.FragColor", "other": "judged_reversed.FragColor"},
            equals=0.3015,
            digits=6,
            note="red, where all three overlap: 0.699 instead of 0.3975",
        ),
    ],
)  # fmt: skip
