"""Grey values: the plain average, and the luminance that the eye sees.

The scene is drawn into a texture first; a second pass draws one rectangle over the whole window and
reads that texture, so each of its pixels can be changed as one likes. The mean of red, green and
blue treats all alike. The eye does not: green looks much brighter than red, and red than blue.
Rec. 709 weighs them by .2126, .7152 and .0722.

Look at: the left half, the average, and the right half, the luminance. The blue ring and the green
box, nearly as dark as each other on the left, part on the right: blue turns almost black. The coral
of the ball (1, .5, .31) is .603333 on the one side and .592582 on the other.
"""

from shaderlab import Case, Output, Texture, assets, computed, formula, fullscreen
from shaderlab.glslmath import swizzle, vec4, where
from shaderlab.reference import post_processing
from shaderlab.sampling import texture

from ..scenes.figures import figure, figures
from ..scenes.still_life import CORAL, photograph_checks, photographed

PATCH = Texture(image=assets.solid((*CORAL, 1.0)))


def post(name, source):
    """The second pass, over one texture or another."""
    return fullscreen(
        "ch08_techniques/post_grayscale.frag", name=name, textures={"screenTexture": source}
    )


def average(screenTexture, TexCoords):
    """The mean of the three channels."""
    return post_processing.average(swizzle(texture(screenTexture, TexCoords), "xyz"))


def luminance(screenTexture, TexCoords):
    """Rec. 709's."""
    return post_processing.luminance(swizzle(texture(screenTexture, TexCoords), "xyz"))


def grey(screenTexture, TexCoords):
    """One on the left, the other on the right."""
    left = swizzle(TexCoords, "x") < 0.5
    both = where(left, average(screenTexture, TexCoords), luminance(screenTexture, TexCoords))
    return vec4(both, both, both, 1.0)


MIDDLE = {"TexCoords": (0.5, 0.5)}

case = Case(
    title="Grey values",
    section="8.2.3",
    math=r"\bar c = \tfrac13 (R + G + B), \qquad Y = .2126\,R + .7152\,G + .0722\,B",
    passes=(photographed(), *post("picture", Output("scene.FragColor")), *post("patch", PATCH)),
    picture="picture.FragColor",
    expect=[
        formula("picture.average", average),
        formula("picture.luminance", luminance),
        formula("picture.FragColor", grey),
        *figures(
            "patch.FragColor",
            {
                f"coral, {side} the middle": ({"TexCoords": (x, 0.5)}, (*(seen,) * 3, 1.0))
                for x, seen, side in ((0.4975, 0.603333, "left of"), (0.5, 0.592582, "in"))
            },
            reference=grey,
        ),
        figure("patch.average", "average of coral", MIDDLE, 0.603333, reference=average),
        figure("patch.luminance", "luminance of coral", MIDDLE, 0.592582, reference=luminance),
        computed(
            "weights of Rec. 709 together",
            lambda: post_processing.luminance((1.0, 1.0, 1.0)),
            equals=1.0,
            digits=4,
            note="white stays white",
        ),
        *photograph_checks(),
    ],
)
