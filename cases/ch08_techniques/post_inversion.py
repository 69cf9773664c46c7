"""Inversion: the difference from white, as in a photographic negative.

The second pass reads the scene's texture and writes 1 − c. Done twice it is the identity, but not
to the last bit: 1 − c is rounded where c is small, and what was lost does not come back.

Look at: the negative. The sky, nearly white, is nearly black, the coral ball light blue, and
shadows are bright.

Try: in `ch08_techniques/post_inversion.frag` write `texture(screenTexture, TexCoords).gbr` for `1.0
- texture(screenTexture, TexCoords).rgb`: the colours change places, and light and dark do not.
"""

from shaderlab import Case, Output, Texture, assets, coverage, formula, measure, value
from shaderlab.glslmath import swizzle, vec4
from shaderlab.glslmath.sampling import texture
from shaderlab.reference import post_processing

from ..scenes.still_life import CORAL, SCENE, photograph_checks, photographed, post_processed


def inverted(name, source):
    """The negative of a texture."""
    return post_processed("post_inversion", source, name)


def negative(screenTexture, TexCoords):
    """One minus the texel, alpha 1."""
    color = swizzle(texture(screenTexture, TexCoords), "xyz")
    return vec4(post_processing.inverse(color), 1.0)


def apart(once, twice):
    """The largest distance of the scene from its negative's negative, in units of 2⁻²⁴."""
    return abs(twice - once)[..., :3].max() * 2.0**24


case = Case(
    title="Inversion",
    section="8.2.3",
    math=r"c' = 1 - c",
    passes=(
        photographed(),
        inverted("picture", SCENE),
        inverted("twice", Output("picture.FragColor")),
        inverted("patch", Texture(image=assets.solid((*CORAL, 1.0)))),
    ),
    picture="picture.FragColor",
    expect=[
        formula("picture.FragColor", negative),
        formula("twice.FragColor", negative, name="the negative's negative"),
        measure(
            "scene against the negative's negative",
            apart,
            reads={"once": "scene.FragColor", "twice": "twice.FragColor"},
            # Two subtractions round by half a unit at most, each. Of a colour below ½, 1 − c has no
            # room for the last bits: some pixel loses a quarter of a unit.
            between=(0.25, 1.0),
            note="in units of 2⁻²⁴, half the spacing of floats below 1: some are not restored",
        ),
        formula("patch.FragColor", negative, name="patch"),
        coverage(64 * 64, pass_name="patch", name="all of the patch"),
        value(
            "patch.FragColor",
            at={"TexCoords": (0.5, 0.5)},
            equals=(0.0, 0.5, 0.69, 1.0),
            digits=6,
            reference=negative,
            name="coral inverted",
        ),
        *photograph_checks(),
    ],
)
