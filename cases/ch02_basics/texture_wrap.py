"""Wrap modes: what a texture shows outside of 0…1.

GL_REPEAT drops the integer part, so that the image begins anew at each integer. GL_MIRRORED_REPEAT
turns every other copy round. GL_CLAMP_TO_EDGE goes on with the outermost texel, and
GL_CLAMP_TO_BORDER with a colour of one's own; with GL_LINEAR the edge is mixed with that colour
over a texel's width. It is texels that are wrapped, by their numbers, not coordinates: so LINEAR
mixes across the seam, from the last texel to the first.

Look at: one image and u and v from −1.5 to 2.5, so that it fits four times. From left to right
stand REPEAT, MIRRORED_REPEAT, CLAMP_TO_EDGE and CLAMP_TO_BORDER, below with NEAREST and above with
LINEAR. Where copies meet, LINEAR blurs under REPEAT and has nothing to blur under the mirror.
"""

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Draw,
    Pass,
    Ramp,
    State,
    Target,
    Texture,
    assets,
    formula,
    fullscreen,
    value,
)
from shaderlab.reference.filtering import linear_sample
from shaderlab.sampling import texture

WRAPS = ("repeat", "mirrored_repeat", "clamp_to_edge", "clamp_to_border")
FILTERS = ("nearest", "linear")
FROM, OVER = -1.5, 4.0

# The picture's image, and one of 5 × 3 texels that are all different, to be judged.
CHART = assets.uv_grid(64, 4)
TEXELS = np.random.default_rng(24).random((3, 5, 4))
BORDER = (0.93, 0.55, 0.20, 1.0)


def wrapped(image, wrap, word):
    """A texture with this wrap mode both ways."""
    return Texture(image=image, wrap=(wrap, wrap), filter=(word, word), border=BORDER)


def tables(name, image, size):
    """Every wrap mode with every filter, in a field of its own."""
    return Pass(
        name=name,
        target=Target(size=size),
        draws=tuple(
            Draw(
                fragment="ch02_basics/textured.frag",
                domain={"TexCoords": Ramp((FROM, FROM), (OVER, 0.0), (0.0, OVER))},
                textures={"image": wrapped(image, wrap, word)},
                state=State(cell=Cell(column=column, row=row, columns=4, rows=2)),
            )
            for row, word in enumerate(FILTERS)
            for column, wrap in enumerate(WRAPS)
        ),
    )


def sampled(image, TexCoords):
    """The specification's equations for the texture's own filter and wrap modes."""
    return texture(image, TexCoords)


def place(name, wrap, word="nearest", image=None):
    """A row of texels, for printed figures."""
    row = np.array([0.25, 0.75]) if image is None else np.array(image)
    return fullscreen(
        "ch02_basics/textured.frag",
        name=name,
        textures={
            "image": Texture(
                image=row[None, :, None] * np.ones(4),
                wrap=(wrap, "repeat"),
                filter=(word, word),
                border=(1.0, 1.0, 1.0, 1.0),
            )
        },
        target=Target(size=(8, 1)),
    )


def figure(name, u, equals, label):
    """What stands at u."""
    return value(
        f"{name}.FragColor",
        at={"TexCoords": (u, 0.5)},
        equals=(equals,) * 4,
        digits=6,
        reference=sampled,
        name=label,
    )


case = Case(
    title="Wrap modes",
    section="2.4.2",
    math=r"\text{repeat: } i \bmod n, \qquad \text{mirror: } (n - 1) - "
    r"\operatorname{mir}\bigl((i \bmod 2n) - n\bigr), \qquad "
    r"\text{edge: } \operatorname{clamp}(i, 0, n - 1)",
    passes=(
        tables("picture", CHART, (1024, 512)),
        # 40 and 32 pixels over 20 and 12 texels: none of them lies on a texel's edge or centre.
        tables("judged", TEXELS, (160, 64)),
        *place("repeat", "repeat"),
        *place("mirror", "mirrored_repeat"),
        *place("edge", "clamp_to_edge"),
        *place("border", "clamp_to_border", "linear", (10.0, 20.0, 30.0, 40.0)),
    ),
    picture="picture.FragColor",
    expect=[
        *(
            formula(
                "judged.FragColor",
                sampled,
                draw=4 * row + column,
                name=f"{wrap}, {word}",
                also={"equation 8.17": linear_sample} if word == "linear" else {},
            )
            for row, word in enumerate(FILTERS)
            for column, wrap in enumerate(WRAPS)
        ),
        figure("repeat", -0.25, 0.75, "REPEAT: −0.25 is 0.75"),
        figure("repeat", 1.25, 0.25, "REPEAT: 1.25 is 0.25"),
        figure("mirror", 1.25, 0.75, "MIRRORED_REPEAT: 1.25 is 0.75"),
        figure("mirror", -0.25, 0.25, "MIRRORED_REPEAT: −0.25 is 0.25"),
        figure("edge", -7.25, 0.25, "CLAMP_TO_EDGE: the first texel"),
        figure("edge", 7.25, 0.75, "CLAMP_TO_EDGE: the last texel"),
        figure("border", -0.05, 3.7, "LINEAR towards a border of 1, at −0.05"),
        figure("border", 1.05, 12.7, "LINEAR towards a border of 1, at 1.05"),
    ],
)
