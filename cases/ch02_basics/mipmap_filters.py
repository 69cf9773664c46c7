"""The four filters that read mipmaps: how to choose within a level, and between levels.

In GL_NEAREST_MIPMAP_LINEAR the first word says how a level is sampled, the second what is done
between levels: NEAREST takes the one that is nearer, LINEAR mixes the two around. The level is the
logarithm of how many texels a pixel covers. All four are for minifying alone: there is nothing
larger than the image itself, and as a magnifying filter OpenGL refuses each of them with 0x500.

Look at: a texture whose levels have each a colour of their own, from level −1 below to 5 above. On
the left are the filters that choose one level, on the right those that mix two; NEAREST within the
level below, LINEAR above. Steps against a smooth change, and sharp chessboards against blurred.
"""

import numpy as np

from shaderlab import Case, Cell, Draw, Pass, Ramp, State, Target, Texture, formula, gl_call, value
from shaderlab.expectations.gl_call import Object, call
from shaderlab.sampling import textureLod

SIDE = 32
COLORS = (
    (0.80, 0.25, 0.20), (0.90, 0.60, 0.15), (0.55, 0.70, 0.25), (0.20, 0.62, 0.55),
    (0.25, 0.42, 0.75), (0.50, 0.30, 0.66),
)  # fmt: skip
WITHIN, BETWEEN = ("nearest", "linear"), ("nearest", "linear")
FILTERS = [f"{a}_mipmap_{b}" for a in WITHIN for b in BETWEEN]


def level(n):
    """A chessboard in the level's own colour."""
    side = SIDE >> n
    place = np.arange(side)
    board = 1.0 - 0.45 * ((place[:, None] + place[None, :]) % 2)
    return np.concatenate([board[..., None] * COLORS[n], np.ones((side, side, 1))], axis=-1)


LEVELS = [level(n) for n in range(len(COLORS))]
NOISE = [np.random.default_rng(n).random((16 >> n, 16 >> n, 4)) for n in range(5)]


def filtered(word, levels):
    """A texture with its levels, minified by this filter."""
    return Texture(image=levels[0], mipmaps=levels[1:], filter=(word, "linear"))


def fields(name, levels, size, start, stop, s, t):
    """The four filters, in a field each: the level grows from below to above."""
    return Pass(
        name=name,
        target=Target(size=size),
        draws=tuple(
            Draw(
                fragment="ch02_basics/mipmapped.frag",
                domain={
                    "TexCoords": Ramp((0.013, 0.027), (s, 0.0), (0.0, t)),
                    "lod": Ramp(start, dy=stop - start),
                },
                textures={"image": filtered(f"{a}_mipmap_{b}", levels)},
                state=State(cell=Cell(column=column, row=row, columns=2, rows=2)),
            )
            for row, a in enumerate(WITHIN)
            for column, b in enumerate(BETWEEN)
        ),
    )


def sampled(image, TexCoords, lod):
    """The specification's choice of levels and texels."""
    return textureLod(image, TexCoords, lod)


# Of plain levels, 0 in the first and n in level n: a sample says which level it came from.
RUNGS = [np.full((16 >> n, 16 >> n, 4), float(n)) for n in range(5)]


def rung(draw, lod, equals):
    """Which level a filter reads, as a number."""
    return value(
        "rungs.FragColor",
        at={"TexCoords": (0.4, 0.4), "lod": lod},
        equals=(equals,) * 4,
        digits=6,
        draw=draw,
        reference=sampled,
        name=f"{FILTERS[draw].upper()} at level {lod:g}",
    )


TEXTURE = call("glBindTexture", "GL_TEXTURE_2D", Object("texture"))

case = Case(
    title="The four mipmap filters",
    section="2.4.4",
    math=r"\text{NEAREST: } d = \lceil \lambda + \tfrac12 \rceil - 1, \qquad "
    r"\text{LINEAR: } \tau = (1 - \operatorname{frac}\lambda)\,\tau^{\lfloor\lambda\rfloor} + "
    r"\operatorname{frac}(\lambda)\,\tau^{\lfloor\lambda\rfloor + 1}",
    passes=(
        fields("picture", LEVELS, (1024, 768), -1.0, 5.4, 0.5, 0.375),
        fields("judged", NOISE, (74, 122), -0.93, 4.61, 1.71, 1.13),
        fields("rungs", RUNGS, (8, 8), -1.0, 5.0, 1.0, 1.0),
    ),
    picture="picture.FragColor",
    expect=[
        *(
            formula("judged.FragColor", sampled, draw=k, name=word.upper())
            for k, word in enumerate(FILTERS)
        ),
        rung(0, 1.4, 1.0),
        rung(0, 1.6, 2.0),
        rung(1, 1.25, 1.25),
        rung(2, 2.75, 3.0),
        rung(3, 2.75, 2.75),
        rung(3, 9.0, 4.0),
        rung(3, -2.0, 0.0),
        *(
            gl_call(
                "glTexParameteri",
                "GL_TEXTURE_2D",
                "GL_TEXTURE_MAG_FILTER",
                f"GL_{word.upper()}",
                before=[TEXTURE],
                raises="invalid_enum",
                name=f"{word.upper()} cannot magnify",
            )
            for word in FILTERS
        ),
        *(
            gl_call(
                "glTexParameteri",
                "GL_TEXTURE_2D",
                "GL_TEXTURE_MIN_FILTER",
                f"GL_{word.upper()}",
                before=[TEXTURE],
                name=f"{word.upper()} minifies",
            )
            for word in FILTERS
        ),
    ],
)
