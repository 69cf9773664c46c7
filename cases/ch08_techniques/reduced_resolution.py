"""Reduced resolution: draw fewer pixels, then enlarge the picture.

Shading costs by the pixel: at half the width and height a quarter of them are left, at a quarter a
sixteenth. The small picture is then enlarged in one pass that only reads a texture. With NEAREST
each texel becomes a block, and slanted edges become stairs; with LINEAR the four nearest texels are
mixed, and edges become soft instead. What is lost is measured against the picture drawn in full: by
the peak signal-to-noise ratio (PSNR), and by FLIP, which follows what an eye sees. On these clear
edges the two disagree: stairs cost more of the signal, and soft edges are what the eye finds.

Look at: one strip of the picture five times: in full; at half the resolution with NEAREST and with
LINEAR; at a quarter with both. And at the table of times: whether smaller is faster depends on what
the vertices cost, which resolution does not change.
"""

from shaderlab import Case, Output, Target, cost, formula, fullscreen, measure, reading
from shaderlab.glslmath import fract, swizzle, vec2, vec4, where
from shaderlab.sampling import texture

from ..scenes.picture_difference import flip, psnr
from ..scenes.still_life import photograph_checks, photographed

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


def copied(screen, TexCoords):
    """What the sampler gives."""
    return texture(screen, TexCoords)


def strips(TexCoords, whole, halved, halvedSmooth, quartered, quarteredSmooth):
    """The strip from one picture or another."""
    place = 5.0 * swizzle(TexCoords, "x")
    st = vec2(0.43 + 0.2 * fract(place), swizzle(TexCoords, "y"))
    half = where(place < 2.0, texture(halved, st), texture(halvedSmooth, st))
    quarter = where(place < 4.0, texture(quartered, st), texture(quarteredSmooth, st))
    both = where(place < 3.0, half, quarter)
    color = where(place < 1.0, texture(whole, st), both)
    return vec4(swizzle(color, "xyz"), 1.0)


def compared(label, statistic, y_label, figures):
    """A table of a statistic over resolutions and filters, each within a fortieth of its figure.

    The figures are bounds on regressions: what llvmpipe draws of this scene. What must hold of any
    scene, as that a smaller picture is a worse one, is measured beside them.
    """
    return measure(
        label,
        statistic,
        readings=[
            reading(
                f"{name}, {filter_}",
                reads={"reference": "full.FragColor", "test": f"{name} {filter_}.FragColor"},
                between=(figure * 0.975, figure * 1.025),
            )
            for (name, filter_), figure in figures.items()
        ],
        y_label=y_label,
    )


def lost(reference, larger, smaller):
    """How many decibel a quarter is worse than a half."""
    return psnr(reference, larger) - psnr(reference, smaller)


def seen_more(reference, larger, smaller):
    """How much more FLIP finds after a quarter than after a half."""
    return flip(reference, smaller) - flip(reference, larger)


def more_signal(nearest, linear, reference):
    """By how many decibel LINEAR is nearer to the picture in full than NEAREST."""
    return psnr(reference, linear) - psnr(reference, nearest)


def more_seen(nearest, linear, reference):
    """How much more FLIP finds after LINEAR than after NEAREST."""
    return flip(reference, linear) - flip(reference, nearest)


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
        formula("half linear.FragColor", copied, name="half, linear"),
        formula("quarter nearest.FragColor", copied, name="quarter, nearest"),
        formula("strips.FragColor", strips, name="five strips"),
        formula("edges.FragColor", strips, name="where one strip ends and the next begins"),
        compared(
            "PSNR",
            psnr,
            "dB",
            {
                ("half", "nearest"): 27.098,
                ("half", "linear"): 28.788,
                ("quarter", "nearest"): 24.134,
                ("quarter", "linear"): 26.176,
            },
        ),
        compared(
            "FLIP",
            flip,
            "mean FLIP",
            {
                ("half", "nearest"): 0.03447,
                ("half", "linear"): 0.04240,
                ("quarter", "nearest"): 0.07099,
                ("quarter", "linear"): 0.08063,
            },
        ),
        *(
            measure(
                label,
                statistic,
                readings=[
                    reading(
                        name,
                        reads={
                            "reference": "full.FragColor",
                            "nearest": f"{name} nearest.FragColor",
                            "linear": f"{name} linear.FragColor",
                        },
                        at_least=0.0,
                    )
                    for name in SMALL
                ],
            )
            for label, statistic in (
                ("PSNR prefers LINEAR, by", more_signal),
                ("FLIP prefers NEAREST, by", more_seen),
            )
        ),
        *(
            measure(
                label,
                statistic,
                readings=[
                    reading(
                        filter_,
                        reads={
                            "reference": "full.FragColor",
                            "larger": f"half {filter_}.FragColor",
                            "smaller": f"quarter {filter_}.FragColor",
                        },
                        at_least=0.0,
                    )
                    for filter_ in FILTERS
                ],
            )
            for label, statistic in (
                ("a quarter is worse than a half, in PSNR by", lost),
                ("a quarter is worse than a half, in FLIP by", seen_more),
            )
        ),
        *photograph_checks(shares=(4.445, 10.962, 5.865), pass_name="full"),
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
