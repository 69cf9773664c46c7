"""FXAA: smooth edges, from nothing but the picture.

A picture that is done still tells where its edges are: where the brightness at a pixel's corners
differs. There the mean of a few places along the edge is taken. Where contrast is low nothing
changes, to the bit, and a picture that is turned by 90° gets the same edges. As it goes by what the
eye sees, it wants colours as a display shows them, not light. What it can't do is bring back what
was lost: where a spoke is thinner than a pixel and its dots do not meet, it smooths dots.

Look at: a Ferris wheel, 72 pixels wide. On the left as it is drawn, on the right after FXAA: the
stairs of its rings are gone, and the sky, which has no edges, is the same.

Try: in `ch15_beyond/fxaa.frag` write `color = far` for `color = luma(far) < least || luma(far) >
most ? near : far`: spokes smear into each other.
"""

import numpy as np

from shaderlab import Case, Output, Ramp, Texture, formula, measure, reading
from shaderlab.glslmath import abs, clamp, dot, max, min, swizzle, vec2, vec3, vec4, where
from shaderlab.glslmath.sampling import textureLod

from ..scenes.ferris_wheel import SIDE, around, frame, side_by_side, wheel
from ..scenes.laws import sampled
from ..scenes.panels import WHOLE, panel_pass

SMOOTH = {"filter": ("linear", "linear"), "wrap": ("clamp_to_edge", "clamp_to_edge")}
CALM = 0.5 + np.random.default_rng(3).uniform(-0.024, 0.024, (24, 24, 4))
# From nearly black on the left to all contrasts on the right, up to the very border.
ROUGH = np.random.default_rng(3).uniform(0.0, np.geomspace(0.02, 1.0, 24)[:, None], (24, 24, 4))


def smoothed(name, image, side=SIDE):
    """A pass of FXAA."""
    of = {"textures": {"image": image}, "size": (side, side)}
    return panel_pass(name, "ch15_beyond/fxaa.frag", WHOLE, **of)


def luma(color):
    """Brightness."""
    return dot(color, vec3(0.299, 0.587, 0.114))


def fxaa(image, TexCoords, frag_coord):
    """Means along edges."""
    places = [(0, 0), (-1, -1), (1, -1), (-1, 1), (1, 1)]
    middle, *corners = around(image, frag_coord, places)
    a, b, c, d = (luma(color) for color in corners)
    least, most = (fold(luma(middle), fold(fold(a, b), fold(c, d))) for fold in (min, max))
    along = vec2(a + b - c - d, b + d - a - c)
    shorter = min(abs(swizzle(along, "x")), abs(swizzle(along, "y")))
    shorter = shorter + max((a + b + c + d) / 32.0, 0.0078125)
    along = clamp(along / shorter, -8.0, 8.0) / float(image.texels.values.shape[0])

    def at(part):
        return swizzle(textureLod(image, TexCoords + part * along, 0.0), "rgb")

    near = 0.5 * (at(-1.0 / 6.0) + at(1.0 / 6.0))
    far = 0.25 * (at(-0.5) + at(0.5)) + 0.5 * near
    edge = where((luma(far) < least) | (luma(far) > most), near, far)
    return vec4(where(most - least >= max(0.05, 0.125 * most), edge, middle), 1.0)


def changed(calm):
    """How much FXAA changes where there is no edge."""
    return np.abs(calm[..., :3] - CALM.astype(np.float32)[..., :3]).max()


def unturned(upright, turned):
    """How far smoothed edges are from those of the turned picture, turned back.

    They are the same but for the weights of a filter, which is asked at turned places: eight bits,
    as Direct3D demands (11.3 functional specification, 7.18.8), put a place 1/256 of a texel off
    either way, and a product of two weights by half of that. OpenGL demands nothing.
    """
    return np.abs(np.rot90(upright) - turned).max()


def roughness(color):
    """The mean difference of neighbours beside each other."""
    return np.abs(np.diff(color[..., :3], axis=1)).mean()


TURNED = {"TexCoords": Ramp((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0))}
FRAME = {"textures": {"image": Output("frame.FragColor")}, "size": (SIDE, SIDE)}
AFTER = {"calm": "calm.FragColor"}
ROUGHNESS = [
    reading(name, reads={"color": f"{name}.FragColor"}, equals=e, digits=3)
    for name, e in (("frame", 0.047), ("fxaa", 0.041))
]
# Of either picture, where neighbours are 1 apart.
OFF = 2.0 * (1.0 + 1.0 + 0.5) / 256.0
BOTH = {"upright": "fxaa.FragColor", "turned": "turned_fxaa.FragColor"}

case = Case(
    title="FXAA",
    section="15.10",
    math=r"c' = \tfrac{1}{2}\left(c(p - \tfrac{t}{6}) + c(p + \tfrac{t}{6})\right), \qquad "
    r"t \perp \nabla \ell",
    passes=(
        frame("frame"),
        panel_pass("turned", "ch02_basics/textured.frag", TURNED, **FRAME),
        smoothed("fxaa", Output("frame.FragColor", **SMOOTH)),
        smoothed("turned_fxaa", Output("turned.FragColor", **SMOOTH)),
        smoothed("calm", Texture(image=CALM, **SMOOTH), 24),
        smoothed("rough", Texture(image=ROUGH, **SMOOTH), 24),
        side_by_side("frame", "fxaa"),
    ),
    picture="picture.FragColor",
    columns=("as drawn", "FXAA"),
    expect=[
        formula("frame.FragColor", wheel, name="the wheel"),
        formula("turned.FragColor", sampled("image"), name="turned"),
        formula("fxaa.FragColor", fxaa, name="means along edges"),
        formula("rough.FragColor", fxaa, name="edges everywhere, in the dark too"),
        measure("change where contrast is low", changed, reads=AFTER, equals=0.0, digits=9),
        measure("edges of the turned wheel", unturned, reads=BOTH, at_most=OFF),
        measure("mean difference of neighbours", roughness, readings=ROUGHNESS),
        formula("picture.FragColor", sampled("image"), draw=0, name="as it is drawn"),
        formula("picture.FragColor", sampled("image"), draw=1, name="after FXAA"),
    ],
)
