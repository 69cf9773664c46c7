"""Transparency in any order: a list that is sorted, or a sum that needs no order.

"Over" wants what is farther first. These petals have no order: each lies over the one to its right,
all the way around. So the order has to be found pixel by pixel. A list keeps each layer's colour
and depth; once sorted, it gives what "over" says, but it takes memory for each layer. A weighted
sum takes two targets, whatever there is: colours times α and a weight that falls with the depth are
added up, 1 − α multiplied. The second is exact: it is how much of the wall is seen. The first is a
mean, and exact where there is one layer, or one colour. A well-known listing gives weights up to
3000 and adds them up in half floats: 22 layers are infinite.

Look at: six petals. Left: drawn one after the other, and the last one lies on both its neighbours.
Middle: lists. Right: weighted; the wheel is round again, but what lies in front is seen less well.

Try: in `ch15_beyond/glass_weighted.frag` write `0.01, 0.01` for `0.01, 300.0`: all weights are the
same, and no petal is in front.
"""

import numpy as np

from shaderlab import Blend, Case, Output, exact, formula, measure
from shaderlab.glslmath import int, max, mix, swizzle, vec3, vec4, where
from shaderlab.glslmath.sampling import texelFetch

from ..scenes import glass
from ..scenes.drawing import chessboard, encoded
from ..scenes.figures import each_draw, results
from ..scenes.glass import PETALS, petal
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import WHOLE, cell, panel, picture, square

SMALL, LARGE = 28, 252
PIXEL = 2.0 / LARGE
WAYS = ("by number", "sorted", "weighted")
SUM = Blend(
    source="one", destination="one", source_alpha="zero", destination_alpha="one_minus_src_alpha"
)


def layered(name, side, petals=range(PETALS)):
    """Each petal in a cell of its own: a list of layers for each pixel."""
    shader, domain = "ch15_beyond/glass_layer.frag", {"place": square()}
    draws = [panel(shader, domain, petal(k, PIXEL), cell=cell(k, 3, 2)) for k in petals]
    return picture(draws, (3 * side, 2 * side), name)


def weighted(name, side, petals=range(PETALS)):
    """The petals' weighted sum."""
    shader, domain = "ch15_beyond/glass_weighted.frag", {"place": square()}
    draws = [panel(shader, domain, petal(k, PIXEL), blend=SUM) for k in petals]
    return picture(draws, (side, side), name, clear=(0.0, 0.0, 0.0, 1.0))


def seen(layers, sums, way, at=None, order=range(PETALS)):
    """A panel of the picture."""
    textures = {
        "colors": Output(f"{layers}.color"),
        "depths": Output(f"{layers}.depth"),
        "lights": Output(f"{sums}.light"),
        "weights": Output(f"{sums}.weight"),
    }
    uniforms = {"way": WAYS.index(way), "order": list(order)}
    of = {"textures": textures, "cell": at}
    return panel("ch15_beyond/order_independent.frag", WHOLE, uniforms, **of)


def shown(name, kind, side):
    """The three ways side by side."""
    draws = [seen(f"{kind}layers", f"{kind}sums", way, cell(k, 3)) for k, way in enumerate(WAYS)]
    return picture(draws, (3 * side, side), name)


def wall(TexCoords):
    """What is behind the petals."""
    return mix(vec3(0.78, 0.72, 0.60), vec3(0.92, 0.88, 0.80), chessboard(6.0 * TexCoords))


def listed(is_sorted):
    """The layers over the wall, from the first to the last, or from the farthest to the nearest."""

    def color(TexCoords, colors, depths, lights):
        side = lights.texels.values.shape[0]
        at = int(TexCoords * float(side))
        cells = [at + np.array([side * (k % 3), side * (k // 3)]) for k in range(PETALS)]
        layers = [(texelFetch(colors, t, 0), swizzle(texelFetch(depths, t, 0), "x")) for t in cells]
        for last in range(PETALS - 1, 0, -1) if is_sorted else ():
            for k in range(last):
                (one, near), (other, far) = layers[k : k + 2]
                wrong = near < far
                layers[k] = where(wrong, other, one), where(wrong, far, near)
                layers[k + 1] = where(wrong, one, other), where(wrong, near, far)
        light = wall(TexCoords)
        for one, _ in layers:
            light = mix(light, swizzle(one, "rgb"), swizzle(one, "a"))
        return vec4(encoded(light), 1.0)

    return color


def mean(TexCoords, lights, weights):
    """The mean of the layers by their weights, and as much of the wall as is left."""
    at = int(TexCoords * float(lights.texels.values.shape[0]))
    light = texelFetch(lights, at, 0)
    one = swizzle(light, "rgb") / max(swizzle(texelFetch(weights, at, 0), "x"), 1.0e-6)
    return vec4(encoded(mix(one, wall(TexCoords), swizzle(light, "a"))), 1.0)


def cells(layers, side):
    """The layers one after the other."""
    return [layers[side * (k // 3) :, side * (k % 3) :][:side, :side] for k in range(PETALS)]


def from_sums(colors, depths, lights, weights):
    """The largest difference of the blended targets from sums and products in float64."""
    side, total, left, by = len(lights), 0.0, 1.0, 0.0
    for color, depth in zip(cells(colors, side), cells(depths, side), strict=True):
        one = glass.weight(color[..., 3:], depth)
        total, left, by = total + one * color[..., :3], left * (1.0 - color[..., 3:]), by + one
    both = zip((lights, weights), ((total, left), (by, 0.0, 0.0, left)), strict=True)
    return np.max([np.abs(seen - np.asarray(vec4(*parts))).max() for seen, parts in both])


def apart(one, other):
    """The largest difference of two pictures."""
    return np.abs(one - other).max()


def until_infinite():
    """How many layers of weight 3000 a half float can't add up."""
    total, layers = np.float16(0.0), 0
    with np.errstate(over="ignore"):
        while np.isfinite(total):
            total, layers = total + np.float16(3000.0), layers + 1
    return layers


def compared(name, one, other):
    """Two pictures that differ by roundings only."""
    reads = {"one": f"{one}.FragColor", "other": f"{other}.FragColor"}
    return measure(name, apart, reads=reads, at_most=2.0**-16)


# What is made of which layers and sums, in which way and order.
MADE = {
    "list": ("layers", "sums", "sorted"),
    "shuffled_list": ("layers", "sums", "sorted", None, (4, 1, 5, 0, 3, 2)),
    "mean": ("layers", "sums", "weighted"),
    "backwards_mean": ("layers", "backwards", "weighted"),
    "one_list": ("single", "one", "sorted"),
    "one_mean": ("single", "one", "weighted"),
}

case = Case(
    title="Transparency in any order",
    section="15.9",
    math=r"C = C_n \mathbin{\text{over}} \dots \mathbin{\text{over}} C_1 \mathbin{\text{over}} B,"
    r"\qquad C \approx \frac{\sum w_i \alpha_i c_i}{\sum w_i \alpha_i}\,(1 - R) + R\,B, \qquad "
    r"R = \prod (1 - \alpha_i)",
    passes=(
        layered("layers", SMALL),
        weighted("sums", SMALL),
        weighted("backwards", SMALL, (5, 4, 3, 2, 1, 0)),
        layered("single", SMALL, (2,)),
        weighted("one", SMALL, (2,)),
        layered("large_layers", LARGE),
        weighted("large_sums", LARGE),
        *(picture([seen(*one)], (SMALL, SMALL), name) for name, one in MADE.items()),
        shown("picture", "large_", LARGE),
        shown("small", "", SMALL),
    ),
    picture="picture.FragColor",
    columns=("one after the other", "lists", "weighted"),
    expect=[
        *each_draw("layers.color", glass.layer, enumerate("123456"), "petal {}"),
        *each_draw("layers.depth", glass.depth, enumerate("123456"), "petal {}: how far"),
        measure(
            "sums and products in float64",
            from_sums,
            reads={
                "colors": "layers.color",
                "depths": "layers.depth",
                "lights": "sums.light",
                "weights": "sums.weight",
            },
            at_most=2.0**-12,
        ),
        formula("small.FragColor", listed(False), draw=0, name="one over the other by number"),
        formula("small.FragColor", listed(True), draw=1, name="a sorted list"),
        formula("small.FragColor", mean, draw=2, name="weighted"),
        exact("shuffled_list.FragColor", Output("list.FragColor"), name="the list in any order"),
        compared("the sum in any order", "mean", "backwards_mean"),
        compared("one layer: weighted is exact", "one_list", "one_mean"),
        enlarged_check(),
        *results({"layers until a sum of half floats is infinite": (until_infinite, 22)}),
    ],
)
