"""Render to texture: what one pass draws is the next one's texture.

A framebuffer object is a set of attachments. With a texture as its colour attachment nothing
reaches the window: the scene is drawn into the texture, and once the default framebuffer is bound
again, that texture can be sampled like any other. Its first row is the lowest one, so texture
coordinate (0, 0) is the scene's lower left corner.

Look at: a box whose sides are screens. They show one scene, which was drawn once. Laid over a
window of its own size, texel on pixel, the texture is the scene bit for bit.

Try: in `ch08_techniques/framebuffer_texture.frag` write `texture(screen, 2.0 * TexCoords)` for
`texture(screen, TexCoords)`: the scene shrinks into a corner of each screen, and its edge fills the
rest.
"""

import numpy as np

from shaderlab import Case, Output, assets, exact, formula, fullscreen, gl_call
from shaderlab.engine.expectations.gl_call import call
from shaderlab.glslmath import min, swizzle, vec4, where
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.transforms import clip_position, device_position, translate

from ..scenes.api import ONE_PIXEL, answers
from ..scenes.cameras import camera, turned
from ..scenes.draws import tested
from ..scenes.figures import figures, results
from ..scenes.laws import unchanged
from ..scenes.panels import picture
from ..scenes.still_life import photograph_checks, photographed

SCREEN = {"screen": Output("scene.FragColor")}
SIDES = (turned(0.0), turned(90.0), turned(-90.0, (1.0, 0.0, 0.0)))  # front, right, above
CAMERA = camera((0.0, 2.7, 4.5), (0.0, -0.06, 0.0), 28.5)


def model(place):
    """Where a screen is on the box, which shows the viewer an edge."""
    return turned(-33.0) @ SIDES[place] @ translate((0.0, 0.0, 0.75))


def farthest_corner():
    """How far a screen's corner is from the middle of the picture, in halves of it."""
    corners = np.array([(x, y, 0.0) for x in (-0.75, 0.75) for y in (-0.75, 0.75)])
    device = [
        device_position(corner, model(k), *CAMERA.values()) for k in range(3) for corner in corners
    ]
    return np.abs(np.array(device)[:, :2]).max()


AWAY = "away from framebuffer 0"
BACK = (call("glBindFramebuffer", "GL_FRAMEBUFFER", 0),)
IS_BOUND = call("glGetIntegerv", "GL_DRAW_FRAMEBUFFER_BINDING")
DARK, WALL = (0.07, 0.07, 0.09, 1.0), (0.62, 0.60, 0.56, 1.0)


def screen(place):
    """One of the screens."""
    return tested(
        "ch08_techniques/framebuffer_texture",
        assets.quad(1.5),
        {"model": model(place), **CAMERA},
        only=("aPos", "aTexCoords"),
        textures=SCREEN,
    )


def shown(TexCoords, screen):
    """A dark rim around the picture."""
    edge = min(TexCoords, 1.0 - TexCoords)
    rim = min(swizzle(edge, "x"), swizzle(edge, "y")) < 0.03
    return where(rim, vec4(*DARK), texture(screen, TexCoords))


case = Case(
    title="Render to texture",
    section="8.2",
    math=r"\text{texture}(s, t) = \text{scene}(\lfloor s\,w \rfloor, \lfloor t\,h \rfloor), \quad "
    r"(0, 0)\ \text{lower left}",
    passes=(
        photographed(),
        picture(map(screen, range(3)), None, "wall", depth="depth24", clear=WALL),
        *fullscreen("ch08_techniques/copy.frag", name="copy", textures=SCREEN),
    ),
    picture="wall.FragColor",
    expect=[
        exact("copy.FragColor", Output("scene.FragColor"), name="texel on pixel, bit for bit"),
        *(
            formula(f"wall.{output}", reference, draw=place, name=f"{word} {place}")
            for place in range(3)
            for output, reference, word in (
                ("gl_Position", clip_position, "screen"),
                ("TexCoords", unchanged("aTexCoords"), "TexCoords"),
                ("FragColor", shown, "picture"),
            )
        ),
        *figures(
            "wall.FragColor",
            {
                "on the left rim": ({"TexCoords": (0.0298, 0.5)}, DARK),
                "on the upper rim": ({"TexCoords": (0.5, 0.9702)}, DARK),
            },
            reference=shown,
        ),
        *answers({"back to framebuffer 0": (IS_BOUND, 0, ONE_PIXEL, BACK)}),
        gl_call(IS_BOUND.function, *IS_BOUND.arguments, before=ONE_PIXEL, at_least=1, name=AWAY),
        *results({"no screen is cut off: farthest corner": (farthest_corner, 0.9362)}, digits=4),
        *photograph_checks(),
    ],
)
