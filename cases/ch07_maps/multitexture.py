"""Several textures at once: a mask chooses between two others at each place.

A program may read from many texture units, at least 16 in a fragment shader. Each sampler holds a
unit's number, each unit a texture; the textures need neither the same size nor the same
coordinates. Here two surfaces repeat several times over the wall, while one mask covers it once and
mixes them: a·(1 − m) + b·m, which is the first where the mask is 0 and the second where it is 1.

Look at: one wall of bricks and plaster that came off in places. Each brick and each crack comes
back after half a wall, but the hole in the plaster does not: the mask is stretched over all.

Try: in `ch07_maps/multitexture.frag` write `texture(plaster, TexCoords), 1.0 - weight` for
`texture(plaster, TexCoords), weight`: bricks and plaster change places.
"""

import numpy as np

from shaderlab import Case, Texture, formula, value
from shaderlab.glslmath import mix, swizzle
from shaderlab.glslmath.sampling import texture

from ..scenes import painted_textures
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import enlarged, panel, picture, rectangle

SMOOTH = ("linear", "linear")
RANDOM = np.random.default_rng(71)
FIRST, SECOND = RANDOM.random((4, 4, 4)), RANDOM.random((8, 3, 4))
LEFT = np.array([[0.0, 0.25, 0.5, 1.0]])
PARTS = np.stack([LEFT, 1.0 - LEFT, 0.6 + 0.0 * LEFT, 1.0 + 0.0 * LEFT], axis=-1)


def holes():
    """The mask: the alpha of a piece of plaster, as red."""
    alpha = painted_textures.plaster(256, seed=4)[..., 3:]
    return np.concatenate([alpha, 0.0 * alpha, 0.0 * alpha, 1.0 + 0.0 * alpha], axis=-1)


def wall(bricks, plaster, mask, filter=("nearest", "nearest")):
    """One wall with its three textures; the surfaces are repeated, the mask is not."""
    images = {"bricks": bricks, "plaster": plaster, "mask": mask}
    domain = {
        "TexCoords": rectangle((0.01, 0.02), (2.06, 1.06)),
        "MaskCoords": rectangle((0.0, 0.0), (1.0, 0.5)),
    }
    textures = {name: Texture(image=image, filter=filter) for name, image in images.items()}
    return [panel("ch07_maps/multitexture.frag", domain, textures=textures)]


def masked(bricks, plaster, mask, TexCoords, MaskCoords):
    """The first where the mask is 0, the second where it is 1."""
    left = swizzle(texture(mask, MaskCoords), "r")
    return mix(texture(bricks, TexCoords), texture(plaster, TexCoords), left)


def part(column, weight):
    """The figure at one texel of the mask, with texels of both surfaces."""
    first, second = FIRST[0, 0], SECOND[0, 0]
    return value(
        "judged.FragColor",
        at={"TexCoords": (0.06, 0.03), "MaskCoords": ((column + 0.5) / 4.0, 0.5)},
        equals=((1.0 - weight) * first + weight * second).tolist(),
        digits=5,
        name=f"a mask of {weight:g}",
    )


case = Case(
    title="Several textures and a mask",
    section="7.1",
    math=r"\text{FragColor} = a(s, t)\,(1 - m(u, v)) + b(s, t)\,m(u, v)",
    passes=(
        *enlarged(
            wall(
                lambda: painted_textures.brick_wall(512),
                lambda: painted_textures.plaster(512),
                holes,
                SMOOTH,
            ),
            (114, 57),
            9,
        ),
        picture(wall(FIRST, SECOND, PARTS), (67, 61), "judged"),
        picture(wall(FIRST, SECOND, PARTS, SMOOTH), (67, 61), "smooth"),
    ),
    picture="picture.FragColor",
    expect=[
        enlarged_check(),
        formula("small.FragColor", masked, name="the wall"),
        formula("judged.FragColor", masked, name="texel by texel"),
        formula("smooth.FragColor", masked, name="with linear filters"),
        part(0, 0.0),
        part(1, 0.25),
        part(2, 0.5),
        part(3, 1.0),
    ],
)
