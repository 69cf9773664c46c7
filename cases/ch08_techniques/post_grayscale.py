"""Grey values: the plain average, and the luminance that the eye sees.

The scene is drawn into a texture first; a second pass draws one rectangle over the whole window and
reads that texture, so each of its pixels can be changed at will. The mean of red, green and blue
treats all channels alike. The eye does not: green looks much brighter than red, and red brighter
than blue. Rec. 709 weighs them by .2126, .7152 and .0722. Its weights are those of light, and a
picture holds numbers that stand for light. To weigh the numbers themselves is called luma, and is a
shortcut. To be right, decode, weigh, encode. The difference is largest for strong colours, and 0
for greys. The notes have the mean alone; the weights are this lesson's.

Look at: the average in the left third, luma in the middle one, and the light's own luminance in the
right one. The blue ring is darkest in the middle one. The coral of the ball (1, .5, .31) is .603333
by the average, .592582 by luma and .639316 by its light.

Try: in `ch08_techniques/post_grayscale.frag` write `color.g) / 2.0` for `color.g + color.b) / 3.0`:
blue things turn darker in the left third.
"""

import numpy as np

from shaderlab import Case, Texture, assets, coverage, formula
from shaderlab.glslmath import swizzle, vec4, where
from shaderlab.glslmath.sampling import texture
from shaderlab.reference import post_processing
from shaderlab.reference.gamma import srgb_decode, srgb_encode

from ..scenes.drawing import decoded, encoded
from ..scenes.figures import figure, figures, results
from ..scenes.still_life import CORAL, SCENE, photograph_checks, photographed, post_processed

PATCH = Texture(image=assets.solid((*CORAL, 1.0)))


def greyed(name, source):
    """The second pass, over one texture or another."""
    return post_processed("post_grayscale", source, name)


def average(screenTexture, TexCoords):
    """The mean of the three channels."""
    return post_processing.average(swizzle(texture(screenTexture, TexCoords), "xyz"))


def luma(screenTexture, TexCoords):
    """Rec. 709's weights, of encoded numbers."""
    return post_processing.luminance(swizzle(texture(screenTexture, TexCoords), "xyz"))


def luminance(screenTexture, TexCoords):
    """Rec. 709's weights of light, encoded."""
    light = decoded(swizzle(texture(screenTexture, TexCoords), "xyz"))
    return encoded(post_processing.luminance(light))


def grey(screenTexture, TexCoords):
    """A third each."""
    x, inputs = swizzle(TexCoords, "x"), (screenTexture, TexCoords)
    right = where(x < 2.0 / 3.0, luma(*inputs), luminance(*inputs))
    seen = where(x < 1.0 / 3.0, average(*inputs), right)
    return vec4(seen, seen, seen, 1.0)


LAWS = {"average": average, "luma": luma, "luminance": luminance}
MIDDLE = {"TexCoords": (0.5, 0.5)}
TOGETHER = post_processing.luminance((1.0, 1.0, 1.0))
BY_SRGB = srgb_encode(post_processing.luminance(srgb_decode(np.array(CORAL))))

case = Case(
    title="Grey values",
    section="8.2.3",
    math=r"\bar c = \tfrac13 (R + G + B), \qquad "
    r"Y^{2.2} = .2126\,R^{2.2} + .7152\,G^{2.2} + .0722\,B^{2.2}",
    passes=(photographed(), greyed("picture", SCENE), greyed("patch", PATCH)),
    picture="picture.FragColor",
    expect=[
        *(formula(f"picture.{output}", law) for output, law in LAWS.items()),
        formula("picture.FragColor", grey),
        formula("patch.FragColor", grey, name="patch"),
        *(formula(f"patch.{output}", law, name=f"patch: {output}") for output, law in LAWS.items()),
        coverage(64 * 64, pass_name="patch", name="all of the patch"),
        *figures(
            "patch.FragColor",
            {
                f"coral at {x}": ({"TexCoords": (x, 0.5)}, (*(seen,) * 3, 1.0))
                for x, seen in (
                    (0.332, 0.603333),
                    (0.335, 0.592582),
                    (0.665, 0.592582),
                    (0.668, 0.639316),
                )
            },
            reference=grey,
        ),
        figure("patch.average", "average of coral", MIDDLE, 0.603333, reference=average),
        figure("patch.luma", "luma of coral", MIDDLE, 0.592582, reference=luma),
        figure("patch.luminance", "luminance of coral", MIDDLE, 0.639316, reference=luminance),
        *results({"luminance of coral by sRGB's own curve": (BY_SRGB, 0.643)}, digits=3),
        *results({"weights of Rec. 709 together": (TOGETHER, 1.0, "white stays white")}, digits=4),
        *photograph_checks(),
    ],
)
