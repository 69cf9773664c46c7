"""Ten boxes: one mesh, ten model matrices, and the depth test to sort it out pixel by pixel.

Every box is drawn in the same way, with its own model matrix: where it stands and how it is
rotated. They are drawn in any order. For each pixel the depth buffer keeps the nearest so far, and
a fragment behind it is discarded; in the end the nearest one wins, in whichever order they came.

Look at: where boxes overlap. What is in front covers what is behind, the right way round for all
ten, although the farthest was drawn last. Each pixel's box is checked against a ray sent through
the scene, which knows nothing of triangles or depth buffers; drawn the other way round, every pixel
comes out the same, bit for bit.

Try: in `ch04_spaces/ten_cubes.vert` write `Normal = aNormal` for `Normal = mat3(model) * aNormal`:
each box takes its light along when it turns, and all show the same bright side.
"""

import numpy as np

from shaderlab import Case, Pixel, Texture, formula, value
from shaderlab.reference.transforms import clip_position, translate

from ..scenes import painted_textures, stage
from ..scenes.boxes import clear_pixels
from ..scenes.cameras import camera, turned
from ..scenes.crates import crates, of_wood, turned_normal
from ..scenes.figures import each_draw, figure, results
from ..scenes.glm import clip_by_glm
from ..scenes.laws import unchanged

CAMERA = camera((0.6, 1.1, 5.6), (0.0, -0.05, -1.5), 45.0, 4.0 / 3.0, far=100.0)
WOOD = Texture(image=painted_textures.crate, filter=("nearest", "nearest"))


def model(k):
    """Box k on a spiral that leads away from the camera, every other one nearer to its middle."""
    depth, turn = 1.0 - 0.75 * k, 0.95 * k + 0.6
    reach = (5.6 - depth) * (0.40 if k % 2 == 0 else 0.19)
    place = (reach * np.cos(turn), 0.62 * reach * np.sin(turn), depth)
    return translate(place) @ turned(24.0 * k + 15.0, (1.0, 0.4 + 0.1 * k, 0.5))


BOXES = [model(k) for k in range(10)]
# The nearest first; numbered from 1.
DRAWS = crates(BOXES, CAMERA, WOOD)


CLEAR = clear_pixels((96, 72), BOXES, CAMERA["projection"] @ CAMERA["view"])
BOX = {k: f"box {k + 1}" for k in range(10)}
GLM = {"PyGLM": clip_by_glm}
LEANING = {"Normal": (-2.0, 1.0, 2.0), "TexCoords": (0.5, 0.5)}
BROWN = (0.309080, 0.210736, 0.117076, 1.0)


def met(x, y, box):
    """The box that a ray meets at a pixel, or the sky."""
    number = float(box) if box else stage.SKY[0]
    return value(
        "judged.box",
        at=Pixel(x, y),
        equals=number,
        digits=6,
        reference=lambda: number,
        name="the box that a ray meets",
    )


case = Case(
    title="Ten boxes",
    section="3.4",
    math=r"\mathbf{c}_k = P\,V\,M_k\,(x, y, z, 1)^{\mathsf T}, \qquad "
    r"\text{pixel} = \operatorname{arg\,min}_k z_k",
    passes=stage.photographed(DRAWS, (800, 600)),
    picture="picture.FragColor",
    expect=[
        *stage.picture_checks("box"),
        *each_draw("judged.gl_Position", clip_position, BOX, "clip coordinates of {}", also=GLM),
        *each_draw("judged.FragColor", of_wood, BOX, "pixels of {}"),
        figure("judged.FragColor", "wood, its normal not of length 1", LEANING, BROWN),
        formula("judged.box", unchanged("number")),
        formula("judged.Normal", turned_normal),
        formula("judged.TexCoords", unchanged("aTexCoords")),
        *(met(*seen) for seen in CLEAR),
        *results({"boxes met by the rays": (len({k for *_, k in CLEAR if k}), 10)}, digits=0),
    ],
)
