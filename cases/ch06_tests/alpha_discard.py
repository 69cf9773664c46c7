"""Discarding fragments: `if (alpha < 0.1) discard;` for leaves and grass on plain rectangles.

A picture of a leaf is a rectangle with an alpha of 0 around the leaf. Drawn as it is, the rectangle
hides what lies behind it: its empty corners write colour and depth like any other fragment.
`discard` ends a fragment before either is written. The leaf is cut out with a hard edge, so it
needs no blending and no drawing order.

Look at: the same leaves twice, the nearest drawn first. On the left nothing is discarded, and each
rectangle's corners cover the leaves behind it; on the right fragments below 0.1 are, and one leaf
shows behind the other although it was drawn later.

Try: in `ch06_tests/leaf.frag` write `alpha < 0.9` for `alpha < threshold`: both sides are cut out
now, with a harder edge.
"""

from shaderlab import Case, Depth, Output, Pixel, across, coverage, exact, formula
from shaderlab.glslmath import abs, clamp, max, mix, swizzle, vec3, vec4

from ..scenes.figures import figure
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import centres, panel, panel_pass, picture, square

THRESHOLD, RAMP = 0.1, "ch06_tests/alpha_discard.frag"
CLEAR = (0.82, 0.87, 0.92, 1.0)
LEAVES = 64  # side of the judged leaf in pixels
WHOLE = (LEAVES, LEAVES)


def leaf_alpha(place):
    """Width of the leaf at this height, less the distance from its middle, eightfold."""
    t = 0.5 + 0.5 * swizzle(place, "y")
    return clamp(8.0 * (2.4 * t * (1.0 - t) - abs(swizzle(place, "x"))), 0.0, 1.0)


def leaf_color(place):
    """The leaf on light grey paper, where it is not thrown away."""
    t, alpha = 0.5 + 0.5 * swizzle(place, "y"), leaf_alpha(place)
    rib = max(1.0 - 14.0 * abs(swizzle(place, "x")), 0.0)
    color = mix(vec3(0.13, 0.36, 0.12), vec3(0.47, 0.68, 0.20), t)
    color = mix(color, vec3(0.78, 0.85, 0.50), 0.7 * rib)
    return vec4(mix(vec3(0.90, 0.90, 0.90), color, alpha), alpha)


def cut(place, threshold):
    """What is thrown away of the leaf."""
    return leaf_alpha(place) < threshold


def ramp_color(alpha):
    """Green with the alpha that came in."""
    return vec4(0.2, 0.5, 0.2, alpha)


def leaf(threshold, depth, box=None):
    """A leaf on a rectangle of the target, or on all of it, at one depth."""
    state = {"depth": Depth(), "viewport": box, "depth_range": (depth, depth)}
    return panel("ch06_tests/leaf.frag", {"place": square()}, {"threshold": threshold}, **state)


def bunches(name, by):
    """Leaves whose corners hide others on the left, cut out on the right; `by` times as large."""
    draws = [
        leaf(threshold, 0.1 + 0.1 * k, (by * x, by * (2 + 8 * (k * 2 % 3)), by * 38, by * 60))
        for left, threshold in ((0, 0.0), (108, THRESHOLD))
        for k, x in enumerate(range(left + 6, left + 81, 15))
    ]
    return picture(draws, (216 * by, 80 * by), name, depth="depth24", clear=CLEAR)


# Pixels of a leaf that are at or above the threshold.
OWN = int((leaf_alpha(centres(LEAVES)) >= THRESHOLD).sum())
KEPT_OF_RAMP = {"discards": lambda alpha: alpha < THRESHOLD, "name": "what is kept of the ramp"}
# Two leaves on the same pixels, the nearer one first: the second shows where the first was cut.
TWO = (leaf(THRESHOLD, 0.25), leaf(0.0, 0.5))
KEPT, RIB = (0.2, 0.5, 0.2, 0.1), (0.636, 0.751, 0.398, 1.0)

case = Case(
    title="Discarding by alpha",
    section="6.3.1",
    math=r"\alpha < 0.1 \implies \text{neither colour nor depth is written}",
    passes=(
        bunches("picture", 3),
        bunches("small", 1),
        panel_pass("ramp", RAMP, {"alpha": across(0.0, 1.0)}, size=(200, 8)),
        panel_pass("edge", RAMP, {"alpha": across(0.0999, 0.1001)}, size=(200, 8)),
        picture([leaf(THRESHOLD, 0.5)], WHOLE, "leaf"),
        picture([leaf(0.0, 0.5)], WHOLE, "whole"),
        picture(TWO, WHOLE, "behind", depth="depth24", clear=CLEAR),
    ),
    picture="picture.FragColor",
    columns=("nothing discarded", "alpha < 0.1 discarded"),
    expect=[
        enlarged_check(),
        formula("small.FragColor", leaf_color, discards=cut, name="the last leaf on the right"),
        coverage(180 * 8, pass_name="ramp", name="180 of 200 columns are kept"),
        coverage(100 * 8, pass_name="edge", name="from 0.0999 to 0.1001, the upper half is kept"),
        figure("edge.FragColor", "0.1 itself is kept", {"alpha": 0.1}, KEPT, reference=ramp_color),
        formula("ramp.FragColor", ramp_color, **KEPT_OF_RAMP),
        figure("ramp.FragColor", "α = 0.1025", Pixel(20, 4), (0.2, 0.5, 0.2, 0.1025)),
        coverage(OWN, pass_name="leaf", name="the leaf's own pixels"),
        formula("leaf.FragColor", leaf_color, discards=cut, name="the leaf"),
        figure("leaf.FragColor", "the middle of the rib", {"place": (0.0, 0.0)}, RIB),
        coverage(LEAVES * LEAVES, pass_name="whole", name="without discard, the whole rectangle"),
        formula("whole.FragColor", leaf_color, name="the leaf and its paper"),
        coverage(OWN, pass_name="behind", draw=0, name="the nearer leaf"),
        coverage(64 * 64 - OWN, pass_name="behind", name="seen where the nearer one is cut"),
        formula("behind.FragColor", leaf_color, name="the farther leaf"),
        exact("behind.FragColor", Output("whole.FragColor"), name="two leaves that are one"),
    ],
)
