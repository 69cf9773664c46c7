"""Tone curves and colour: where very bright red, green and blue go.

A curve that bends each channel by itself bends hues, too. Of a bright orange, red is cut off first
and green follows, so it turns yellow; in the end all colours are one of six, or white. ACES, the
film industry's curve, leads bright colours to white on purpose, and its common fits bend hues on
the way: Narkowicz's by up to 39°, where clipping makes 63°. Hill's mixes the channels first: 27°,
and blue turns purple. OKLab has a coordinate for lightness, so that a curve can leave the angle of
the hue alone; only what no display can show is cut.

Look at: all hues from left to right, eleven stops of exposure upward. Upper left is clipping, with
its six stripes; beside it Narkowicz's fit. Below are Hill's fit and the curve in OKLab, whose
columns keep their hue up to white.

Try: in `lib/tone_curves.glsl` write `(1.0 - square)` for `(1.0 - square * square * square)`:
colours fade sooner.
"""

import numpy as np

from shaderlab import Case, formula, measure, reading
from shaderlab.glslmath import abs, clamp, exp2, fract, mix, pow, swizzle, vec3, vec4

from ..scenes import tone_curves
from ..scenes.colour_science import oklab_by_colour_science
from ..scenes.drawing import decoded
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, rectangle

CURVES = {
    "clipped": lambda light: light,
    "Narkowicz": tone_curves.filmic,
    "Hill": tone_curves.filmic_wide,
    "OKLab": tone_curves.perceptual,
}
PLACE = {"place": rectangle((0.0, -5.0), (1.0, 11.0))}


def chart(number):
    """All hues at all exposures, through one of the curves."""
    at = cell(number, 2, 2, from_above=True)
    return panel("ch15_beyond/tone_curves.frag", PLACE, {"curve": number}, cell=at)


def light(place):
    """The light before the curve."""
    turns = fract(swizzle(place, "x") + vec3(0.0, 2.0, 1.0) / 3.0)
    pure = clamp(abs(turns * 6.0 - 3.0) - 1.0, 0.0, 1.0)
    return exp2(swizzle(place, "y")) * mix(vec3(1.0), pure, 0.9)


def lab(place):
    """The light in OKLab."""
    return tone_curves.to_oklab(light(place))


def again(place):
    """The light there and back: the light itself."""
    return tone_curves.from_oklab(lab(place))


def curved(place):
    """The curve in OKLab, before a display cuts it."""
    return tone_curves.perceptual(light(place))


def through(curve):
    """What is shown of the light."""

    def color(place):
        return vec4(pow(clamp(curve(light(place)), 0.0, 1.0), 1.0 / 2.2), 1.0)

    return color


def from_colour_science(light, lab):
    """How far OKLab is from colour-science's, as a share of the lightness."""
    return np.max(np.abs(lab - oklab_by_colour_science(light)) / lab[..., :1])


def turned(shown, light, number):
    """How far a curve turns a hue at most, in degrees, where colours can be told."""
    side = len(light) // 2
    y, x = (1 - int(number) // 2) * side, int(number) % 2 * side
    of, seen = (image[y : y + side, x : x + side, :3] for image in (light, decoded(shown)))
    colour = np.hypot(*np.moveaxis(tone_curves.to_oklab(seen)[..., 1:], -1, 0))
    apart = tone_curves.hue(seen) - tone_curves.hue(of)
    return np.max(np.abs((apart + 180.0) % 360.0 - 180.0)[colour > 0.05])


def kept(light, curved):
    """How far the curve in OKLab turns a hue, in degrees, where there is colour left."""
    lab = tone_curves.to_oklab(np.maximum(curved, 0.0))
    inside = (curved > 0.0).all(-1) & (np.hypot(lab[..., 1], lab[..., 2]) > 0.01)
    apart = tone_curves.hue(curved) - tone_curves.hue(light)
    return np.max(np.abs((apart + 180.0) % 360.0 - 180.0)[inside])


def lost(light, again):
    """The largest change of light that went to OKLab and back, as a share of it."""
    return np.max(np.abs(again - light) / light.max(axis=-1, keepdims=True))


LAB = {"light": "small.light", "lab": "small.lab"}
AGAIN = {"light": "small.light", "again": "small.again"}
CURVED = {"light": "small.light", "curved": "small.curved"}
SHOWN = {"shown": "small.FragColor", "light": "small.light"}

case = Case(
    title="Tone curves and hues",
    section="15.5",
    math=r"L' = \frac{L}{\sqrt{1 + L^2}}, \qquad "
    r"(a', b') = \frac{L'}{L}\left(1 - L'^6\right)(a, b)",
    passes=enlarged([chart(k) for k in range(4)], (32, 32), 11),
    picture="picture.FragColor",
    rows=("clipped, Narkowicz's", "Hill's, in OKLab"),
    expect=[
        *(
            formula("small.FragColor", through(curve), draw=k, name=name)
            for k, (name, curve) in enumerate(CURVES.items())
        ),
        formula("small.light", light),
        formula("small.lab", lab, name="the light in OKLab"),
        formula("small.again", again, name="OKLab, there and back"),
        enlarged_check(),
        measure("OKLab by colour-science", from_colour_science, reads=LAB, at_most=0.001),
        formula("small.curved", curved, name="the curve in OKLab"),
        measure("hues turned by the curve in OKLab, in degrees", kept, reads=CURVED, at_most=0.01),
        measure("changed there and back", lost, reads=AGAIN, at_most=2.0**-14),
        measure(
            "hues turned at most, in degrees",
            turned,
            readings=[
                reading(name, reads=SHOWN, given={"number": k}, equals=degrees, digits=0)
                for k, (name, degrees) in enumerate(zip(CURVES, (63, 39, 27, 17), strict=True))
            ],
        ),
    ],
)
