"""Six orders of the same three matrices: scale, rotate and translate do not commute.

In T·R·S·p the matrix next to the point acts first. Scale first and the letter is stretched along
its own axes; rotate first and it is stretched along the world's, which shears nothing here but
stretches another side of it. Translate before a rotation and it swings around the origin; before a
scaling, and its distance is scaled with it. "Scale, then rotate, then translate" is the order that
does what its words say to the thing itself. In C++ the product begins with glm::mat4(1.0f): since
GLM 0.9.9 (release notes: "no more default initialization") glm::mat4 without an argument holds
whatever was in memory, often zeros, which stay zeros in every product.

Look at: where the six letters are. All have been stretched to (2, 1, 1), turned by 90° around z and
moved by (1, 2, 3). The rods follow the black point at its foot, (1, 0, 0), through the steps: green
for the scaling, gold for the rotation, blue for the translation.

Try: in `ch03_transforms/transform_order.vert` write `first * (second * (third * vec4(aPos, 1.0)))`
for `third * (second * (first * vec4(aPos, 1.0)))`: the letters of each row change places.
"""

from itertools import accumulate

import numpy as np

from shaderlab import Case, Erratum, assets, formula
from shaderlab.glslmath import mul, vec4
from shaderlab.reference.transforms import normal_matrix, scale, translate, world_normal

from ..scenes import painted_solids as solids, stage
from ..scenes.cameras import camera, turned
from ..scenes.figures import each_draw, figure, results
from ..scenes.glm import scaled_then_rotated_by_glm, translated_from_by_glm
from ..scenes.laws import projected
from ..scenes.props import letter_f, tile, way

STEPS = {
    "S": (scale((2.0, 1.0, 1.0)), solids.GREEN),
    "R": (turned(90.0, (0.0, 0.0, 1.0)), solids.GOLD),
    "T": (translate((1.0, 2.0, 3.0)), solids.BLUE),
}
# As mathematics writes them: the last letter acts first. Where (1, 0, 0) ends up.
ORDERS = {
    "T·R·S": (1.0, 4.0, 3.0),
    "S·R·T": (-4.0, 2.0, 3.0),
    "S·T·R": (2.0, 3.0, 3.0),
    "R·T·S": (-2.0, 3.0, 3.0),
    "T·S·R": (1.0, 3.0, 3.0),
    "R·S·T": (-2.0, 4.0, 3.0),
}
POINT = np.array([1.0, 0.0, 0.0, 1.0])
CAMERA = camera((1.2, 6.0, 16.0), (-0.8, 1.35, 0.8), 19.6, 8.0 / 3.0, near=1.0, far=40.0)
LETTER = assets.joined(
    letter_f(),
    solids.rod((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), solids.INK, 0.04),
    solids.painted(solids.box((0.88, -0.12, -0.12), (1.12, 0.12, 0.12)), solids.INK),
)
GHOST = solids.repainted(LETTER, (0.62, 0.66, 0.70), 0.85)


def path(order):
    """Rods from (1, 0, 0) to where each step takes it."""
    matrices, colors = zip(*(STEPS[name] for name in reversed(order.split("·"))), strict=True)
    places = accumulate(matrices, lambda here, matrix: matrix @ here, initial=POINT)
    return way([place[:3] for place in places], colors)


def panel(place, order):
    """One order: floor, the letter at the origin, the way, and the letter at its end."""
    for solid in (tile(4.5, 1.0), GHOST, path(order)):
        yield stage.prop(solid, CAMERA, cell=place)
    first, second, third = (STEPS[name][0] for name in reversed(order.split("·")))
    normals = {"normalMatrix": normal_matrix(third @ second @ first)}
    uniforms = {"first": first, "second": second, "third": third, **normals, **CAMERA}
    yield stage.subject("ch03_transforms/transform_order.vert", LETTER, uniforms, cell=place)


def placed(aPos, first, second, third):
    """third · (second · (first · (x, y, z, 1)))."""
    return mul(third, mul(second, mul(first, vec4(aPos, 1.0))))


def placed_at_once(aPos, first, second, third):
    """The same by NumPy: one product of three matrices, then the points."""
    return (third @ second @ first @ np.column_stack([aPos, np.ones(len(aPos))]).T).T


def product(order):
    """Where (1, 0, 0, 1) ends up under one matrix that is the product of three."""
    left, middle, right = (STEPS[name][0] for name in order.split("·"))
    return (left @ middle @ right @ POINT)[:3]


# The letter of each order, where it ends up.
LETTERS = {4 * k + 3: order for k, order in enumerate(ORDERS)}
FLOORS = {4 * k: f"floor of {order}" for k, order in enumerate(ORDERS)}
ONE, AT_ONCE = {"aPos": (1.0, 0.0, 0.0)}, {"one product of matrices": placed_at_once}
BY_GLM = "(1, 0, 0) by glm::scale, and then glm::rotate"
FROM_ZEROS = "(1, 0, 0), begun with zeros: there is no place left, w is 0"
FROM_ONE = "(1, 0, 0), begun with glm::mat4(1)"
NOTE = "scaled first, it would be at (0, 2, 0)"

case = Case(
    title="The order of transforms",
    section="3.5",
    math=r"T\,R\,S\,p = T\,(R\,(S\,p)) \ne S\,R\,T\,p, \qquad p = (1, 0, 0),\ S = (2, 1, 1),\ "
    r"R = 90^\circ_z,\ T = (1, 2, 3)",
    passes=stage.gallery(panel, ORDERS, 2, (960, 540)),
    picture="picture.FragColor",
    columns=("one order", "the reversed one"),
    rows=("T·R·S, S·R·T", "S·T·R, R·T·S", "T·S·R, R·S·T"),
    expect=[
        *stage.checks(),
        *each_draw("judged.Placed", placed, LETTERS, "{} of every vertex", also=AT_ONCE),
        *stage.color_checks(LETTERS),
        *stage.color_checks(FLOORS),
        *(
            figure("judged.Placed", order, ONE, (*ORDERS[order], 1.0), reference=placed, draw=draw)
            for draw, order in LETTERS.items()
        ),
        *results({f"{o} as one matrix": (product(o), ORDERS[o]) for o in ORDERS}, digits=12),
        *results({BY_GLM: (scaled_then_rotated_by_glm((1, 0, 0)), (0, 1, 0), NOTE)}, digits=12),
        *results({FROM_ONE: (translated_from_by_glm(1.0), (2.0, 2.0, 3.0, 1.0))}, digits=12),
        *results({FROM_ZEROS: (translated_from_by_glm(0.0), (0.0, 0.0, 0.0, 0.0))}, digits=12),
        formula("judged.gl_Position", projected(placed, homogeneous=True), name="clip coordinates"),
        formula("judged.Normal", world_normal, name="normals"),
    ],
    errata=[
        Erratum(
            section="3.4",
            says="scale → rotate → translate, where the code calls glm::scale and then glm::rotate",
            truth="GLM multiplies on the right: what is called last acts first, so the vertex is "
            "rotated, and then scaled",
            proof=BY_GLM,
        ),
        Erratum(
            section="4.2",
            says="glm::mat4 model; is an identity matrix",
            truth="it was until GLM 0.9.9; glm::mat4(1.0f) is one in every version",
            proof=FROM_ZEROS,
        ),
    ],
)
