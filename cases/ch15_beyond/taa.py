"""TAA: many samples a pixel, a few of them in each frame.

The camera is shifted by a part of a pixel, by another one for each frame, and each frame is mixed
into what was there before. With a share α for the new one, (1 − α)ⁿ of a frame is left n frames
later; with 1/n for the n-th, that is the mean of all shifts, as if each pixel had n samples. What
has moved leaves ghosts, unless the history is cut to the range of colours about the pixel. In bytes
a history stops short: once α times what is missing is less than half a code, it stays as it is.

Look at: a Ferris wheel, 72 pixels wide. On the left is one frame, on the right the mean of eight:
the spokes are whole, though none of the eight frames has them whole.

Try: in `ch15_beyond/edges_scene.frag` write `vec2 at = place;` for `vec2 at = place + jitter;`: all
frames are the same, and their mean has the same hard edges.
"""

import numpy as np

from shaderlab import Case, Output, Texture, exact, formula, measure
from shaderlab.glslmath import clamp, int, max, min, mix, swizzle, vec4
from shaderlab.glslmath.sampling import texelFetch

from ..scenes.ferris_wheel import SIDE, around, frame, side_by_side, wheel
from ..scenes.figures import results
from ..scenes.laws import sampled
from ..scenes.panels import panel_pass

FRAMES = 8
BLACK, WHITE = Texture(image=np.zeros((4, 4, 4))), Texture(image=np.ones((4, 4, 4)))
NIGHT = Texture(image=np.zeros((SIDE, SIDE, 4)))
# A history that is darker here and brighter there than all that is near.
STREWN = Texture(image=np.random.default_rng(15).random((SIDE, SIDE, 4)))


def halton(k, base):
    """The k-th number that is spread evenly over 0…1 by its digits to a base."""
    total, part = 0.0, 1.0
    while k:
        k, digit = divmod(k, base)
        part /= base
        total += part * digit
    return total


def blended(name, frame, history, share, moving=False, side=SIDE):
    """A pass that mixes a frame into a history."""
    textures = {"frame": frame, "history": history}
    uniforms = {"share": share, "moving": moving}
    of = {"textures": textures, "size": (side, side)}
    return panel_pass(name, "ch15_beyond/taa.frag", {}, uniforms, **of)


def means():
    """The mean of the frames, one after the other."""
    for k in range(FRAMES):
        yield frame(f"frame_{k}", (halton(k + 1, 2) - 0.5, halton(k + 1, 3) - 0.5))
        past = Output(f"mean_{k - 1}.FragColor") if k else NIGHT
        yield blended(f"mean_{k}", Output(f"frame_{k}.FragColor"), past, 1.0 / (k + 1))


def fading():
    """White that is mixed with black four times."""
    for k in range(4):
        past = Output(f"fading_{k - 1}.FragColor") if k else WHITE
        yield blended(f"fading_{k}", BLACK, past, 0.25, side=4)


def taa(frame, history, frag_coord, share):
    """What was there before, cut to what is about the pixel, and a share of the frame."""
    near = around(frame, frag_coord, [(x, y) for y in (-1, 0, 1) for x in (-1, 0, 1)])
    least = most = near[4]
    for color in near:
        least, most = min(least, color), max(most, color)
    past = texelFetch(history, int(swizzle(frag_coord, "xy")), 0)
    return vec4(mix(clamp(swizzle(past, "rgb"), least, most), near[4], share), 1.0)


def from_mean(mean, a, b, c, d, e, f, g, h):
    """How far the last history is from the mean of eight frames."""
    return np.abs(mean - (a + b + c + d + e + f + g + h) / 8.0).max()


def missing():
    """In bytes, how far a history stops from white when a tenth of white is added each time."""
    level = 0
    while (after := round(level + 0.1 * (255 - level))) != level:
        level = after
    return 255 - level


LAST = f"mean_{FRAMES - 1}"
READ = {name: f"frame_{k}.FragColor" for k, name in enumerate("abcdefgh")}
READ["mean"] = f"{LAST}.FragColor"

case = Case(
    title="TAA",
    section="15.11",
    math=r"h_n = (1 - \alpha)\,h_{n - 1} + \alpha\,c_n, \qquad \alpha = \tfrac{1}{n}:\ "
    r"h_n = \frac{1}{n} \sum_{k \le n} c_k",
    passes=(
        frame("frame"),
        *means(),
        *fading(),
        frame("later", (9.0, 0.0)),
        blended("moved", Output("later.FragColor"), STREWN, 0.1, moving=True),
        side_by_side("frame", LAST),
    ),
    picture="picture.FragColor",
    columns=("one frame", "mean of eight"),
    expect=[
        formula("frame.FragColor", wheel, name="the wheel"),
        *(formula(f"frame_{k}.FragColor", wheel, name=f"shifted, {k}") for k in (2, 4)),
        measure("from the mean of all frames", from_mean, reads=READ, at_most=2.0**-21),
        exact("fading_3.FragColor", (0.31640625, 0.31640625, 0.31640625, 1.0), name="(1 − ¼)⁴"),
        formula("moved.FragColor", taa, name="a history that is cut"),
        formula("picture.FragColor", sampled("image"), draw=0, name="one frame"),
        formula("picture.FragColor", sampled("image"), draw=1, name="the mean of eight"),
        *results({"codes from white where a history in bytes stops": (missing, 5)}),
    ],
)
