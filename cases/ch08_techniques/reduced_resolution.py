"""Reduced resolution: draw fewer pixels, then enlarge the picture.

The cost of shading grows with the pixels: half the width and height leaves a quarter of them, a
quarter a sixteenth. The small picture is then enlarged in one pass that only reads a texture. With
NEAREST each texel becomes a block, and slanted edges become stairs; with LINEAR the four nearest
texels are mixed, and edges become soft instead. What is lost is measured against the picture drawn
in full: by the peak signal-to-noise ratio (PSNR), and by FLIP, which follows what an eye sees. On
these clear edges the two disagree: stairs cost more of the signal, and soft edges are what the eye
finds.

Look at: one strip of the picture five times: in full; at half the resolution with NEAREST and with
LINEAR; at a quarter with both. And at the table of times: whether smaller is faster depends on what
the vertices cost, which resolution does not change.

Try: in `ch08_techniques/reduced_resolution.frag` write `vec4(0.5 + 2.0 * (color - texture(whole,
st).rgb), 1.0)` for `vec4(color, 1.0)`: what is lost remains, on grey: nothing on the left, then
more and more edges.
"""

from shaderlab import Case, Output, Target, cost, formula, fullscreen, measure, reading
from shaderlab.glslmath import fract, swizzle, vec2, vec4, where
from shaderlab.glslmath.sampling import texture

from ..scenes.laws import sampled
from ..scenes.picture_difference import flip, psnr
from ..scenes.still_life import hue_checks, photograph_checks, photographed

SIDE = 256
SMALL = {"half": 2, "quarter": 4}
FILTERS = ("nearest", "linear")


def enlarged(name, filter_):
    """A small picture at full size."""
    return fullscreen(
        "ch08_techniques/copy.frag",
        name=f"{name} {filter_}",
        textures={"screen": Output(f"{name}.FragColor", filter=(filter_, filter_))},
        target=Target(size=(SIDE, SIDE)),
    )


def shown(name, filter_):
    """The same as a texture, texel on pixel."""
    return Output(f"{name} {filter_}.FragColor")


def five_strips(name, target):
    """The five strips side by side."""
    (drawn,) = fullscreen(
        "ch08_techniques/reduced_resolution.frag",
        name=name,
        textures={
            "whole": Output("full.FragColor"),
            "halved": shown("half", "nearest"),
            "halvedSmooth": shown("half", "linear"),
            "quartered": shown("quarter", "nearest"),
            "quarteredSmooth": shown("quarter", "linear"),
        },
        target=target,
    )
    return drawn


def strips(TexCoords, whole, halved, halvedSmooth, quartered, quarteredSmooth):
    """The strip from one picture or another."""
    place = 5.0 * swizzle(TexCoords, "x")
    st = vec2(0.43 + 0.2 * fract(place), swizzle(TexCoords, "y"))
    half = where(place < 2.0, texture(halved, st), texture(halvedSmooth, st))
    quarter = where(place < 4.0, texture(quartered, st), texture(quarteredSmooth, st))
    both = where(place < 3.0, half, quarter)
    color = where(place < 1.0, texture(whole, st), both)
    return vec4(swizzle(color, "xyz"), 1.0)


def signal(reference, test, than=None):
    """The PSNR in decibel; or by how much it is more than another picture's."""
    return psnr(reference, test) - (0.0 if than is None else psnr(reference, than))


def seen(reference, test, than=None):
    """What FLIP finds; or by how much it is more than in another picture."""
    return flip(reference, test) - (0.0 if than is None else flip(reference, than))


def drawn(name, filter_):
    """An enlarged picture's output."""
    return f"{name} {filter_}.FragColor"


def more(label, test, than):
    """A row that says that one picture has more than another; one and the same has 0 more."""
    return reading(label, reads={"test": drawn(*test), "than": drawn(*than)}, at_least=0.001)


def table(label, statistic, y_label, *laws):
    """A statistic of each picture, which goes by the scene, and what holds of any scene."""
    pictures = [(name, filter_) for name in SMALL for filter_ in FILTERS]
    return measure(
        label,
        statistic,
        reads={"reference": "full.FragColor"},
        readings=[*(reading(", ".join(p), reads={"test": drawn(*p)}) for p in pictures), *laws],
        y_label=y_label,
        own_types=True,
    )


case = Case(
    title="Reduced resolution",
    section="8.7",
    math=r"\mathrm{PSNR} = 10 \log_{10} \frac{1}{\overline{(a - b)^2}}",
    passes=(
        photographed("full", (SIDE, SIDE)),
        *(photographed(name, (SIDE // by, SIDE // by)) for name, by in SMALL.items()),
        *(each for name in SMALL for filter_ in FILTERS for each in enlarged(name, filter_)),
        # Wide enough that pixels lie within a hundredth of where one strip ends.
        five_strips("edges", Target(size=(640, 6))),
        five_strips("strips", None),
    ),
    picture="strips.FragColor",
    expect=[
        formula("half linear.FragColor", sampled("screen"), name="half, linear"),
        formula("quarter nearest.FragColor", sampled("screen"), name="quarter, nearest"),
        formula("strips.FragColor", strips, name="five strips"),
        formula("edges.FragColor", strips, name="where one strip ends and the next begins"),
        table(
            "PSNR",
            signal,
            "dB",
            *(more(f"half over quarter, {f}", ("half", f), ("quarter", f)) for f in FILTERS),
            *(more(f"LINEAR over NEAREST, {n}", (n, "linear"), (n, "nearest")) for n in SMALL),
        ),
        table(
            "FLIP",
            seen,
            "mean FLIP",
            *(more(f"quarter over half, {f}", ("quarter", f), ("half", f)) for f in FILTERS),
            *(more(f"LINEAR over NEAREST, {n}", (n, "linear"), (n, "nearest")) for n in SMALL),
        ),
        *photograph_checks(side=SIDE, pass_name="full"),
        *(
            check
            for name, by in SMALL.items()
            for check in hue_checks(SIDE // by, name, f"{name}: ")
        ),
        cost(
            {
                "enlarged": {
                    1: "full",
                    2: ("half", "half linear"),
                    4: ("quarter", "quarter linear"),
                },
                "in full": {1: "full", 2: "full", 4: "full"},
            },
            claim="drawing smaller and enlarging takes less time",
            cheaper=("enlarged", "in full"),
            draw_calls={"in full": lambda n: 1, "enlarged": lambda n: 1 if n == 1 else 2},
            over="1 / scale",
        ),
    ],
)
