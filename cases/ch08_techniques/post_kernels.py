"""Kernels: each pixel becomes a weighted sum of itself and its eight neighbours.

Nine weights, laid over a pixel and its neighbours, sharpen, blur, or find edges. Weights that add
up to 1 keep an even surface as bright as it was (sharpen: 5 − 4, blur: 16 / 16); those of the edge
kernel add up to 0, so that even surfaces go black and only changes remain. The sum is not
everything: a kernel of eight times 2 and −15 adds up to 1 as well, but its middle is negative, and
it answers a step from 0 to 1 with 6 and −5. It inverts edges; a kernel that sharpens answers with
−1 and 2, darker before the step and brighter after it. What is asked for beyond the edge of the
picture must be decided: here its last row and column are repeated. The notes name no kernel; the
five here are common ones.

Look at: the five pictures, and how the kernel with −15 in its middle draws each edge twice. The
last kernel, an emboss, is not the same turned round: it shows whether the weights' rows run from
top to bottom, as they are printed, or the other way.

Try: in `ch08_techniques/post_kernels.frag` write `vec2(column - 1, row - 1)` for `vec2(column - 1,
1 - row)`: only the emboss changes: all other kernels are the same upside down.
"""

import numpy as np

from shaderlab import Case, Pixel, Texture, Variant, formula
from shaderlab.glslmath import swizzle, vec4
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.post_processing import BLUR, EDGES, EMBOSS, SHARPEN, convolved, filtered

from ..scenes.figures import figures, results
from ..scenes.panels import WHOLE, rectangle
from ..scenes.still_life import SCENE, photograph_checks, photographed, post_processed

INVERTING = (2.0, 2.0, 2.0, 2.0, -15.0, 2.0, 2.0, 2.0, 2.0)
# Weights; their sum; what is left of a step from 0 to 1, before it and after it.
KERNELS = {
    "sharpen": (SHARPEN, 1.0, -1.0, 2.0),
    "eight times 2 around −15": (INVERTING, 1.0, 6.0, -5.0),
    "blur": (BLUR, 1.0, 0.25, 0.75),
    "edges": (EDGES, 0.0, 3.0, -3.0),
    "emboss": (EMBOSS, 1.0, 3.0, 4.0),
}
STEP = Texture(image=np.array([[(level,) * 3 + (1.0,) for level in (0.0, 0.0, 1.0, 1.0)]] * 4))

# Noise, read 1/200 of a texel from each texel's lower left corner: a neighbour that is not exactly
# one texel away is another one.
WIDE, HIGH = 32, 24
NOISE = Texture(image=np.random.default_rng(8).uniform(0.0, 1.0, (HIGH, WIDE, 4)))
NEAR_A_CORNER = {"TexCoords": rectangle((-0.495 / WIDE, -0.495 / HIGH), (1.0, 1.0))}


def around(screenTexture, TexCoords, kernel):
    """Nine texels by their weights, the upper left one first."""
    height, width = screenTexture.texels.values.shape[:2]
    texel = np.array([1.0 / width, 1.0 / height])
    neighbours = [
        swizzle(texture(screenTexture, TexCoords + texel * np.array([x, y])), "xyz")
        for y in (1.0, 0.0, -1.0)
        for x in (-1.0, 0.0, 1.0)
    ]
    return vec4(filtered(neighbours, kernel), 1.0)


def by_numpy(screenTexture, TexCoords, kernel):
    """The whole image through NumPy's convolution, and of that the judged pixels."""
    image = screenTexture.texels.values[..., :3]
    whole = convolved(image, [float(weight[0]) for weight in kernel])
    x, y = np.floor(TexCoords * np.array(image.shape[1::-1])).astype(int).T
    return np.column_stack([whole[y, x], np.ones(len(x))])


def sharpened(name, source, size=None, domain=WHOLE):
    """A texture through the first kernel; each variant sends its own."""
    return post_processed("post_kernels", source, name, domain=domain, size=size, kernel=SHARPEN)


def answers(before, behind):
    """What a kernel makes of the two pixels at a step."""
    rows = {
        f"{side} a step from 0 to 1": (Pixel(x, 1), (seen,) * 3 + (1.0,))
        for x, side, seen in ((1, "before", before), (2, "behind", behind))
    }
    return figures("step.FragColor", rows)


case = Case(
    title="Kernels",
    section="8.2.3",
    math=r"c'(x, y) = \sum_{i=-1}^{1} \sum_{j=-1}^{1} w_{ij}\, c(x + i,\, y + j)",
    passes=(
        photographed(),
        sharpened("main", SCENE),
        sharpened("corners", NOISE, (WIDE, HIGH), NEAR_A_CORNER),
        sharpened("step", STEP, (4, 4)),
    ),
    picture="main.FragColor",
    variants=[
        Variant(name, {"kernel": kernel}, expect=answers(*steps))
        for name, (kernel, _, *steps) in KERNELS.items()
    ],
    expect=[
        formula("main.FragColor", around, also={"NumPy's convolution": by_numpy}),
        formula("corners.FragColor", around, name="read near each texel's corner"),
        formula("step.FragColor", around, name="a step"),
        *results({f"weights, {name}": (sum(k), total) for name, (k, total, *_) in KERNELS.items()}),
        *photograph_checks(),
    ],
)
