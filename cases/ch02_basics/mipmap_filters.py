"""The four filters that read mipmaps: how to choose within a level, and between levels.

In GL_NEAREST_MIPMAP_LINEAR the first word says how a level is sampled, the second what is done
between levels: NEAREST takes the one that is nearer, LINEAR mixes the two around. The level is the
logarithm of how many texels a pixel covers. All four are for minifying alone: there is nothing
larger than the image itself, and as a magnifying filter OpenGL refuses each of them with 0x500. Up
to level 0 the magnifying filter takes over: here NEAREST beside LINEAR_MIPMAP_…, and LINEAR beside
NEAREST_MIPMAP_…, where OpenGL lets a driver magnify up to level ½.

Look at: a texture whose levels each have their own colour, from level −1 below to 2½ above. On the
left are the filters that choose one level, on the right those that mix two; NEAREST within the
level below, LINEAR above. Steps against a smooth change, and sharp chessboards against blurred. In
the lowest band of each the other filter magnifies.

Try: in `ch02_basics/mipmapped.frag` write `TexCoords, floor(lod)` for `TexCoords, lod`: levels are
whole numbers now, so all four change in steps and mix nothing.
"""

import numpy as np

from shaderlab import Case, Texture, gl_call, measure, up
from shaderlab.engine.expectations.gl_call import Object, call
from shaderlab.glslmath.sampling import textureLod

from ..scenes.figures import each_draw, figure
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, picture, rectangle

SIDE = 8
FIELD = 8  # pixels a side, of fields whose level comes from derivatives
LEVEL = (1.3, 1.7)
COLORS = ((0.80, 0.25, 0.20), (0.90, 0.60, 0.15), (0.55, 0.70, 0.25), (0.20, 0.62, 0.55))
# The first word is for within a level, the last for between levels.
FILTERS = [f"{a}_mipmap_{b}" for a in ("nearest", "linear") for b in ("nearest", "linear")]


def level(n):
    """A chessboard in the level's own colour."""
    side = SIDE >> n
    place = np.arange(side)
    board = 1.0 - 0.45 * ((place[:, None] + place[None, :]) % 2)
    return np.concatenate([board[..., None] * COLORS[n], np.ones((side, side, 1))], axis=-1)


LEVELS = [level(n) for n in range(len(COLORS))]
NOISE = [np.random.default_rng(n).random((16 >> n, 16 >> n, 4)) for n in range(5)]
# Of plain levels, 0 in the first and n in level n: a sample says which level it came from.
RUNGS = [np.full((16 >> n, 16 >> n, 4), float(n)) for n in range(5)]


def magnifying(word):
    """The magnifying filter beside one for minifying: not the one that it has within a level."""
    return "nearest" if word.startswith("linear") else "linear"


def derived():
    """The four filters, each with 2^1.3 and 2^1.7 texels a pixel: here the level follows from the
    derivatives of the coordinates."""
    for k, (word, lod) in enumerate((word, lod) for lod in LEVEL for word in FILTERS):
        extent = (2.0**lod * FIELD / 16.0,) * 2
        image = Texture(image=RUNGS[0], mipmaps=RUNGS[1:], filter=(word, magnifying(word)))
        yield panel(
            "ch02_basics/textured.frag",
            {"TexCoords": rectangle((0.013, 0.027), extent)},
            textures={"image": image},
            cell=cell(k, 4, 2),
        )


def derived_level(k):
    """The level that the k-th field of them shows."""

    def shown(FragColor):
        left, below = FIELD * (k % 4), FIELD * (k // 4)
        block = FragColor[below : below + FIELD, left : left + FIELD]
        return float(block.mean()) if np.ptp(block) < 1e-6 else float("nan")

    return shown


def fields(levels, lods, extent):
    """The four filters, in a field each: the level grows from below to above."""
    domain = {"TexCoords": rectangle((0.013, 0.027), extent), "lod": up(*lods)}
    for k, word in enumerate(FILTERS):
        image = Texture(image=levels[0], mipmaps=levels[1:], filter=(word, magnifying(word)))
        yield panel(
            "ch02_basics/mipmapped.frag", domain, textures={"image": image}, cell=cell(k, 2, 2)
        )


def sampled(image, TexCoords, lod):
    """The specification's choice of levels and texels."""
    return textureLod(image, TexCoords, lod)


def rung(draw, lod, equals):
    """Which level a filter reads, as a number."""
    return figure(
        "rungs.FragColor",
        f"{FILTERS[draw].upper()} at level {lod:g}",
        {"TexCoords": (0.4, 0.4), "lod": lod},
        (equals,) * 4,
        draw=draw,
        reference=sampled,
    )


def told(which, word, **more):
    """A texture is told to minify or magnify with one of the four."""
    return gl_call(
        "glTexParameteri",
        "GL_TEXTURE_2D",
        f"GL_TEXTURE_{which}_FILTER",
        f"GL_{word}",
        before=[call("glBindTexture", "GL_TEXTURE_2D", Object("texture"))],
        **more,
    )


WORDS = [word.upper() for word in FILTERS]

case = Case(
    title="The four mipmap filters",
    section="2.4.4",
    math=r"\text{NEAREST: } d = \lceil \lambda + \tfrac12 \rceil - 1, \qquad "
    r"\text{LINEAR: } \tau = (1 - \operatorname{frac}\lambda)\,\tau^{\lfloor\lambda\rfloor} + "
    r"\operatorname{frac}(\lambda)\,\tau^{\lfloor\lambda\rfloor + 1}",
    passes=(
        *enlarged(fields(LEVELS, (-1.0, 2.5), (1.0, 0.75)), (146, 110), 7),
        picture(fields(NOISE, (-0.93, 4.61), (1.71, 1.13)), (74, 122), "judged"),
        picture(fields(RUNGS, (-1.0, 5.0), (1.0, 1.0)), (8, 8), "rungs"),
        picture(derived(), (4 * FIELD, 2 * FIELD), "derived"),
    ),
    picture="picture.FragColor",
    columns=("one level", "two levels mixed"),
    rows=("LINEAR in a level", "NEAREST in a level"),
    expect=[
        enlarged_check(),
        *each_draw(
            "small.FragColor", sampled, {k: f"{word}, levels" for k, word in enumerate(WORDS)}
        ),
        *each_draw("judged.FragColor", sampled, enumerate(WORDS)),
        rung(0, 1.4, 1.0),
        rung(0, 1.6, 2.0),
        rung(1, 1.25, 1.25),
        rung(2, 2.75, 3.0),
        rung(3, 2.75, 2.75),
        rung(3, 9.0, 4.0),
        rung(3, -2.0, 0.0),
        *each_draw(
            "rungs.FragColor", sampled, {k: f"{word}, the level" for k, word in enumerate(WORDS)}
        ),
        # An isotropic footprint: the level is the logarithm of texels a pixel (equations 8.7 to
        # 8.11, where a driver may be off by what its logarithm and its fraction of 8 bits are).
        *(
            measure(
                f"{word}, 2^{lod} texels a pixel",
                derived_level(k),
                reads={"FragColor": "derived.FragColor"},
                **(
                    {"between": (lod - 0.05, lod + 0.05)}
                    if word.endswith("LINEAR")
                    else {"equals": round(lod), "digits": 6}
                ),
            )
            for k, (word, lod) in enumerate((word, lod) for lod in LEVEL for word in WORDS)
        ),
        *(told("MAG", w, raises="invalid_enum", name=f"{w} cannot magnify") for w in WORDS),
        *(told("MIN", w, name=f"{w} minifies") for w in WORDS),
    ],
)
