"""Render to texture: what one pass draws is the next one's texture.

A framebuffer object is a set of attachments. With a texture as its colour attachment nothing
reaches the window: the scene is drawn into the texture, and once the default framebuffer is bound
again, that texture can be sampled like any other. Its first row is the lowest one, so texture
coordinate (0, 0) is the scene's lower left corner.

Look at: three screens in a row that show one scene, which was drawn once. Laid over a window of its
own size, texel on pixel, the texture is the scene bit for bit.
"""

from math import radians

from shaderlab import (
    Case,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    State,
    Target,
    assets,
    exact,
    formula,
    fullscreen,
    value,
)
from shaderlab.glslmath import min, swizzle, vec4, where
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    perspective,
    rotate,
    translate,
    world_normal,
)
from shaderlab.sampling import texture

from ..scenes.still_life import photograph_checks, photographed
from ..scenes.studio import handed_on, studio_color

VIEW = look_at((0.0, 2.4, 4.4), (0.0, 0.35, 0.1))
PROJECTION = perspective(radians(38.0), 1.0, 0.1, 20.0)
SCREEN = Mesh(**assets.quad(1.5)).only("aPos", "aTexCoords")
ANGLES = (40.0, 0.0, -40.0)


def screen(place):
    """One of the screens, turned towards the viewer."""
    turned = rotate(radians(ANGLES[place]), (0.0, 1.0, 0.0))
    return Draw(
        vertex="ch08_techniques/framebuffer_texture.vert",
        fragment="ch08_techniques/framebuffer_texture.frag",
        mesh=SCREEN,
        uniforms={
            "model": translate((1.5 * place - 1.5, 0.0, 0.3 * abs(place - 1))) @ turned,
            "view": look_at((0.0, 0.5, 5.0), (0.0, 0.0, 0.0)),
            "projection": PROJECTION,
        },
        textures={"screen": Output("scene", "FragColor")},
        state=State(depth=Depth()),
    )


def place_of(aTexCoords):
    """A corner's place in the texture, handed on."""
    return aTexCoords


def shown(TexCoords, screen):
    """A dark rim around the picture."""
    edge = min(TexCoords, 1.0 - TexCoords)
    rim = min(swizzle(edge, "x"), swizzle(edge, "y")) < 0.03
    return where(rim, vec4(0.07, 0.07, 0.09, 1.0), texture(screen, TexCoords))


def rim(place, name):
    """A place on the rim, by TexCoords."""
    return value(
        "wall.FragColor",
        at={"TexCoords": place},
        equals=(0.07, 0.07, 0.09, 1.0),
        digits=6,
        reference=shown,
        name=name,
    )


case = Case(
    title="Render to texture",
    section="8.2",
    math=r"\text{texture}(s, t) = \text{scene}(\lfloor s\,w \rfloor, \lfloor t\,h \rfloor), \quad "
    r"(0, 0)\ \text{lower left}",
    passes=(
        photographed(VIEW, PROJECTION),
        Pass(
            name="wall",
            target=Target(depth="depth24", clear=(0.62, 0.60, 0.56, 1.0)),
            draws=tuple(screen(place) for place in range(3)),
        ),
        *fullscreen(
            "ch08_techniques/copy.frag",
            name="copy",
            textures={"screen": Output("scene", "FragColor")},
        ),
    ),
    picture="wall.FragColor",
    expect=[
        exact("copy.FragColor", Output("scene", "FragColor"), name="texel on pixel, bit for bit"),
        *(
            expectation
            for place in range(3)
            for expectation in (
                formula("wall.gl_Position", clip_position, draw=place, name=f"screen {place}"),
                formula("wall.TexCoords", place_of, draw=place, name=f"TexCoords {place}"),
                formula("wall.FragColor", shown, draw=place, name=f"picture {place}"),
            )
        ),
        rim((0.0298, 0.5), "on the left rim"),
        rim((0.5, 0.9702), "on the upper rim"),
        *photograph_checks(
            clip_position, world_normal, handed_on, studio_color, shares=(4.468, 10.962, 5.957)
        ),
    ],
)
