"""Wrap modes: what a texture shows outside of 0…1.

GL_REPEAT drops the integer part, so that the image begins anew at each integer. GL_MIRRORED_REPEAT
mirrors every other copy. GL_CLAMP_TO_EDGE continues with the outermost texel, and
GL_CLAMP_TO_BORDER with a colour that the program chooses; with GL_LINEAR the edge is mixed with
that colour over a texel's width. Wrapping applies to texel numbers, not to coordinates, so LINEAR
mixes across the seam, from the last texel to the first. A texture in three dimensions is a stack of
layers, between which LINEAR mixes as well, and has a third wrap mode, for r.

Look at: a letter of 8 × 8 texels, and u and v from −1.5 to 2.5, so that it fits four times. Where
copies meet, LINEAR blurs under REPEAT and has nothing to blur under the mirror. Above it a block of
wood in three dimensions, and four cuts through it and what surrounds it: s grows to the right and r
upward, and the cut climbs along t a little.

Try: in `ch02_basics/textured.frag` write `texture(image, fract(TexCoords))` for `texture(image,
TexCoords)`: all four strips repeat the image, whatever their mode.
"""

import numpy as np

from shaderlab import Case, Ramp, Target, Texture, Texture3D, formula, fullscreen, gl_call
from shaderlab.engine.expectations.gl_call import Object, call
from shaderlab.reference.filtering import linear_sample

from ..scenes.figures import each_draw, figure
from ..scenes.laws import sampled
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, picture, square

WRAPS = ("repeat", "mirrored_repeat", "clamp_to_edge", "clamp_to_border")
FIELDS = [(word, wrap) for word in ("nearest", "linear") for wrap in WRAPS]

# One of 5 × 3 texels that are all different, to be judged.
TEXELS = np.random.default_rng(24).random((3, 5, 4))
SOLID_TEXELS = np.random.default_rng(24).random((4, 3, 5, 4))
VOLUME = (call("glBindTexture", "GL_TEXTURE_3D", Object("texture")),)
BORDER = (0.93, 0.55, 0.20, 1.0)

cut_through = sampled("solid")  # the same equations with a third coordinate


def letter():
    """The picture's image: an F on a field that grows red to the right and green upward."""
    rows = ("", "", " *", " *", " ***", " *", " *****", "")
    y, x = (np.indices((8, 8)) + 0.5) / 8.0
    field = np.stack([0.1 + 0.7 * x, 0.15 + 0.6 * y, 0.75 - 0.5 * x, np.ones((8, 8))], axis=-1)
    field[[[c == "*" for c in row.ljust(8)] for row in rows]] = (1.0, 0.97, 0.86, 1.0)
    return field


def wood():
    """A block of wood, 32 texels a side: rings around an axis that is not quite upright."""
    t, r, s = np.moveaxis((np.indices((32, 32, 32)) + 0.5) / 32.0, 0, 0)[[1, 0, 2]]
    ring = 7.0 * np.hypot(s - 0.25 - 0.15 * r, t - 0.1)
    light = 1.0 - 0.62 * (ring % 1.0) ** 3
    return np.stack([0.86 * light, 0.62 * light, 0.36 * light, np.ones(light.shape)], axis=-1)


def wrapped(image, rows=2):
    """Every wrap mode with every filter, in a field of its own."""
    for k, (word, wrap) in enumerate(FIELDS):
        texels = Texture(image=image, wrap=(wrap, wrap), filter=(word, word), border=BORDER)
        domain, textures = {"TexCoords": square(-1.497, 2.503)}, {"image": texels}
        place = cell(k, 4, rows)
        yield panel("ch02_basics/textured.frag", domain, textures=textures, cell=place)


def cuts(layers, fields, first, rows):
    """Each wrap mode in all three dimensions: from the `first` cell on, a slanting cut each."""
    cut = Ramp((-1.497, 0.203, -1.497), (4.0, 0.0, 0.0), (0.0, 0.5, 4.0))
    for k, (word, wrap) in enumerate(fields, first):
        solid = Texture3D(layers=layers, wrap=(wrap,) * 3, filter=(word, word), border=BORDER)
        domain, textures = {"TexCoords": cut}, {"solid": solid}
        yield panel("ch02_basics/solid.frag", domain, textures=textures, cell=cell(k, 4, rows))


def texels(name, wrap, row, word="nearest"):
    """A row of texels, for printed figures."""
    image = Texture(
        image=np.array(row)[None, :, None] * np.ones(4),
        wrap=(wrap, "repeat"),
        filter=(word, word),
        border=(1.0, 1.0, 1.0, 1.0),
    )
    return fullscreen(
        "ch02_basics/textured.frag",
        name=name,
        textures={"image": image},
        target=Target(size=(8, 1)),
    )


def at(name, u, equals, label):
    """What stands at u, a row further up: whatever the mode along s, along t the row repeats."""
    point = {"TexCoords": (u, 1.5)}
    return figure(f"{name}.FragColor", label, point, (equals,) * 4, reference=sampled("image"))


case = Case(
    title="Wrap modes",
    section="2.4.2",
    math=r"\text{repeat: } i \bmod n, \qquad \text{mirror: } (n - 1) - "
    r"\operatorname{mir}\bigl((i \bmod 2n) - n\bigr), \qquad "
    r"\text{edge: } \operatorname{clamp}(i, 0, n - 1)",
    passes=(
        *enlarged([*wrapped(letter(), 3), *cuts(wood(), FIELDS[4:], 8, 3)], (116, 87), 9),
        # 40 and 32 pixels over 20 and 12 texels: none of them lies on a texel's edge or centre.
        picture(wrapped(TEXELS), (160, 64), "judged"),
        picture(cuts(SOLID_TEXELS, FIELDS, 0, 2), (160, 68), "solid"),
        *texels("repeat", "repeat", (0.25, 0.75)),
        *texels("mirror", "mirrored_repeat", (0.25, 0.75)),
        *texels("edge", "clamp_to_edge", (0.25, 0.75)),
        *texels("border", "clamp_to_border", (10.0, 20.0, 30.0, 40.0), "linear"),
    ),
    picture="picture.FragColor",
    columns=("REPEAT", "MIRRORED_REPEAT", "CLAMP_TO_EDGE", "CLAMP_TO_BORDER"),
    rows=("three dimensions", "LINEAR", "NEAREST"),
    expect=[
        enlarged_check(),
        *each_draw(
            "small.FragColor",
            sampled("image"),
            {k: f"the letter, {wrap}, {word}" for k, (word, wrap) in enumerate(FIELDS)},
        ),
        *(
            formula(
                "judged.FragColor",
                sampled("image"),
                draw=k,
                name=f"{wrap}, {word}",
                also={"equation 8.17": linear_sample} if word == "linear" else {},
            )
            for k, (word, wrap) in enumerate(FIELDS)
        ),
        *each_draw("small.FragColor", cut_through, dict(enumerate(WRAPS, 8)), "the wood, {}"),
        *each_draw(
            "solid.FragColor",
            cut_through,
            {k: f"three dimensions, {wrap}, {word}" for k, (word, wrap) in enumerate(FIELDS)},
        ),
        *(
            gl_call(
                "glGetTexParameteriv",
                *("GL_TEXTURE_3D", f"GL_TEXTURE_WRAP_{axis}"),
                before=VOLUME,
                returns="GL_REPEAT",
                name=f"along {axis.lower()} a new texture repeats",
            )
            for axis in "STR"
        ),
        gl_call(
            "glTexImage2D",
            *("GL_TEXTURE_3D", 0, "GL_RGBA8", 1, 1, 0, "GL_RGBA", "GL_UNSIGNED_BYTE", None),
            before=VOLUME,
            raises="invalid_enum",
            name="no image in two dimensions fits it: 0x0500",
        ),
        *(
            formula(f"{name}.FragColor", sampled("image"), name=f"a row of texels, {name}")
            for name in ("repeat", "mirror", "edge", "border")
        ),
        at("repeat", -0.25, 0.75, "REPEAT: −0.25 is 0.75"),
        at("repeat", 1.25, 0.25, "REPEAT: 1.25 is 0.25"),
        at("mirror", 1.25, 0.75, "MIRRORED_REPEAT: 1.25 is 0.75"),
        at("mirror", -0.25, 0.25, "MIRRORED_REPEAT: −0.25 is 0.25"),
        at("edge", -7.25, 0.25, "CLAMP_TO_EDGE: the first texel"),
        at("edge", 7.25, 0.75, "CLAMP_TO_EDGE: the last texel"),
        at("border", -0.05, 3.7, "LINEAR towards a border of 1, at −0.05"),
        at("border", 1.05, 12.7, "LINEAR towards a border of 1, at 1.05"),
    ],
)
