"""Ten boxes: one mesh, ten model matrices, and the depth test to sort it out pixel by pixel.

Every box goes the same way to the screen, with one model matrix of its own: where it stands and how
it is turned. They are drawn in any order. For each pixel the depth buffer keeps the nearest so far,
and a fragment that lies behind is thrown away; in the end the nearest has won, whichever came
first.

Look at: where boxes overlap. What is in front covers what is behind, the right way round for all
ten, although the farthest was drawn last. Each pixel's box is checked against a ray sent through
the scene, which knows nothing of triangles or depth buffers; drawn the other way round, every pixel
comes out the same, bit for bit.
"""

from math import radians

import numpy as np

from shaderlab import (
    Case,
    Depth,
    Draw,
    Mesh,
    Pixel,
    State,
    Texture,
    assets,
    computed,
    formula,
    value,
)
from shaderlab.assets.order import any_order
from shaderlab.glslmath import mul, swizzle
from shaderlab.reference.transforms import clip_position, look_at, perspective, rotate, translate
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.boxes import nearest_box
from ..scenes.glm import clip_by_glm
from ..scenes.studio import softened, studio_color

VIEW = look_at((0.6, 1.1, 5.6), (0.0, -0.05, -1.5))
PROJECTION = perspective(radians(45.0), 4.0 / 3.0, 0.1, 100.0)


def model(k):
    """Box k on a spiral that leads away from the camera, every other one nearer to its middle."""
    depth, turn = 1.0 - 0.75 * k, 0.95 * k + 0.6
    reach = (5.6 - depth) * (0.40 if k % 2 == 0 else 0.19)
    place = (reach * np.cos(turn), 0.62 * reach * np.sin(turn), depth)
    return translate(place) @ rotate(radians(24.0 * k + 15.0), (1.0, 0.4 + 0.1 * k, 0.5))


BOXES = [model(k) for k in range(10)]
WOOD = Texture(image=assets.crate, filter=("nearest", "nearest"))
JUDGED = (96, 72)


def box(k):
    """One box, numbered from 1."""
    return Draw(
        vertex="ch04_spaces/ten_cubes.vert",
        fragment="ch04_spaces/ten_cubes.frag",
        mesh=Mesh(**assets.cube()),
        uniforms={
            "model": BOXES[k],
            "view": VIEW,
            "projection": PROJECTION,
            "number": float(k + 1),
        },
        textures={"wood": WOOD},
        state=State(depth=Depth()),
    )


NEAR_FIRST = [box(k) for k in range(10)]


def of_wood(Normal, TexCoords, wood):
    """The texel under a pixel, in the studio's light."""
    color = swizzle(texture(wood, TexCoords), "xyz")
    return studio_color(1.3 * color * color, Normal)


def box_number(number):
    """What the box's own number should be wherever the box is seen."""
    return number


def turned_normal(aNormal, model):
    """A normal of a box that is only turned."""
    return mul(model[:3, :3], aNormal)


def texture_place(aTexCoords):
    """Texture coordinates are only handed on."""
    return aTexCoords


def clear_pixels():
    """Pixels well inside a box, or well beside all: rays a pixel off meet the same one."""
    x, y = np.meshgrid(np.arange(4, JUDGED[0], 5), np.arange(4, JUDGED[1], 5))
    around = [
        nearest_box(x + 0.5 + dx, y + 0.5 + dy, JUDGED, BOXES, PROJECTION @ VIEW)
        for dx in (-1, 0, 1)
        for dy in (-1, 0, 1)
    ]
    alike = np.ptp(around, axis=0) == 0
    wanted = alike & ((around[0] > 0) | ((x + y) % 3 == 0))
    return np.stack([x, y, around[0]], axis=-1)[wanted].tolist()


CLEAR = clear_pixels()

case = Case(
    title="Ten boxes",
    section="3.4",
    math=r"\mathbf{c}_k = P\,V\,M_k\,(x, y, z, 1)^{\mathsf T}, \qquad "
    r"\text{pixel} = \operatorname{arg\,min}_k z_k",
    passes=(
        *stage.photographed(NEAR_FIRST, (800, 600)),
    ),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        any_order("judged.FragColor"),
        *(
            formula("judged.gl_Position", clip_position, draw=k, also={"PyGLM": clip_by_glm},
                    name=f"clip coordinates of box {k + 1}")
            for k in range(10)
        ),
        *(
            formula("judged.FragColor", of_wood, draw=k, name=f"pixels of box {k + 1}")
            for k in range(10)
        ),
        value(
            "judged.FragColor",
            at={"Normal": (-2.0, 1.0, 2.0), "TexCoords": (0.5, 0.5)},
            equals=(0.346979, 0.244959, 0.143558, 1.0),
            digits=6,
            name="wood, its normal not of length 1",
        ),
        formula("judged.box", box_number),
        formula("judged.Normal", turned_normal),
        formula("judged.TexCoords", texture_place),
        any_order("judged.box"),
        *(
            value("judged.box", at=Pixel(x, y), equals=expected, digits=6,
                  reference=lambda expected=expected: expected, name="the box that a ray meets")
            for x, y, expected in ((x, y, float(k) if k else stage.SKY[0]) for x, y, k in CLEAR)
        ),
        computed(
            "boxes met by the rays",
            lambda: len({k for *_, k in CLEAR if k}),
            equals=10,
            digits=0,
        ),
    ],
)  # fmt: skip
