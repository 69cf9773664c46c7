"""Rotation around x, y, z or any axis: cos φ along, sin φ across, and the axis itself stays.

Around z, x becomes (cos φ, sin φ): two columns of the matrix are the places where x and y end up.
Any other axis u needs three terms: cos φ of the vector, sin φ of u × v at right angles to it, and 1
− cos φ of its part along u, which must not shrink. Turning is linear, so it leaves the origin in
its place; a translation comes after it, in the last column.

Look at: the letters, from pale to bright in three equal steps around the black arrow: by 90° around
x and y above, around z below, and by 120° around (1, 1, 1). Point your right thumb along the arrow,
and the fingers curl as the letters go. A third of a turn around (1, 1, 1) brings x to y, y to z and
z to x.

Try: in `ch03_transforms/rotate.vert` write `0.0 * outerProduct(u, u)` for `(1.0 - cos(angle)) *
outerProduct(u, u)`: letters shrink along their axis, which the third term prevents.
"""

from math import radians

from shaderlab import Case, Erratum, formula
from shaderlab.glslmath import normalize
from shaderlab.reference.transforms import rotate, rotated, translate

from ..scenes import painted_solids as solids, stage
from ..scenes.cameras import camera
from ..scenes.figures import each_draw, figures, results
from ..scenes.glm import rotated_by_glm
from ..scenes.laws import projected
from ..scenes.props import letter_f, tile

AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "any": (1, 1, 1)}
FULL = {"x": 90.0, "y": 90.0, "z": 90.0, "any": 120.0}
# From where each is seen, and the point in the middle of its part of the picture.
VIEWS = {
    "x": ((3.6, 1.9, 2.8), (0.3, 0.3, 0.1)),
    "y": ((2.6, 3.4, 3.8), (0.1, 0.25, 0.0)),
    "z": ((1.2, 1.7, 4.5), (-0.05, 0.25, 0.1)),
    "any": ((2.2, 2.3, 3.9), (0.2, 0.3, 0.3)),
}


def quarter(place, name):
    """One axis: a floor, the axis as an arrow, and the letter in four positions, first pale."""
    view = camera(*VIEWS[name], 33.0, 4.0 / 3.0)
    unit = normalize([float(a) for a in AXES[name]])
    for solid in (tile(1.2, 0.4), solids.arrow(1.6 * unit, color=solids.INK, thickness=0.026)):
        yield stage.prop(solid, view, cell=place)
    for step in (0.0, 1.0, 2.0, 3.0):
        letter = solids.repainted(letter_f(), (0.66, 0.69, 0.72), 0.85 * (1.0 - step / 3.0))
        angle = radians(FULL[name] * step / 3.0)
        offset = 0.012 * (step + 1.0) * unit  # so that no two lie in one plane
        turn = {"axis": AXES[name], "angle": angle, "offset": offset, **view}
        yield stage.subject("ch03_transforms/rotate.vert", letter, turn, cell=place)


def turned(aPos, axis, angle, offset):
    """Rodrigues's formula, then the translation."""
    return rotated(aPos, normalize(axis), angle) + offset


def turned_normal(aNormal, axis, angle):
    """Normals turn like everything else, and are not translated."""
    return rotated(aNormal, normalize(axis), angle)


LAST = {6 * k + 5: name for k, name in enumerate(AXES)}
TURNS = {draw: f"{FULL[axis]:g}° around {axis}" for draw, axis in LAST.items()}
THIRD = {"aPos": (1, 0, 0), "axis": (5, 5, 5), "angle": radians(120), "offset": (0, 0, 0)}
RIGHT = {**THIRD, "axis": (0, 0, 1), "angle": radians(90)}
# (1, 2, 3), turned by 30° around z and moved by (5, 6, 7): as equation 3.4 should read, and reads.
TURNED = {"aPos": (1.0, 2.0, 3.0), "axis": (0.0, 0.0, 1.0), "angle": radians(30.0)}
MENDED = (4.866025, 8.232051, 10.0)
PRINTED = (-0.133975, 2.232051, 10.0), "V₁ and V₂ are missing"
AT_ONCE = translate((5, 6, 7)) @ rotate(radians(30), (0, 0, 1)) @ (1, 2, 3, 1)

case = Case(
    title="Rotation",
    section="3.2",
    math=r"R\,v = v\cos\varphi + (u \times v)\sin\varphi + u\,(u \cdot v)(1 - \cos\varphi), \qquad "
    r"R_z = \begin{pmatrix} \cos\varphi & -\sin\varphi & 0 & V_1 \\ \sin\varphi & \cos\varphi & 0 "
    r"& V_2 \\ 0 & 0 & 1 & V_3 \\ 0 & 0 & 0 & 1 \end{pmatrix}",
    passes=stage.gallery(quarter, AXES, 2, (800, 600)),
    picture="picture.FragColor",
    rows=("around x, around y", "around z, around (1, 1, 1)"),
    expect=[
        *stage.checks(),
        *each_draw("judged.Turned", turned, TURNS, also={"PyGLM": rotated_by_glm}),
        formula("judged.Normal", turned_normal, name="normals turn"),
        formula("judged.gl_Position", projected(turned), name="clip coordinates"),
        *stage.color_checks(LAST, "colour, around {}"),
        *figures(
            "judged.Turned",
            {
                "x becomes y": (RIGHT, (0.0, 1.0, 0.0)),
                "a third of a turn around (5, 5, 5)": (THIRD, (0.0, 1.0, 0.0)),
                "equation 3.4, mended": ({**TURNED, "offset": (5.0, 6.0, 7.0)}, MENDED),
                "equation 3.4, as printed": ({**TURNED, "offset": (0.0, 0.0, 7.0)}, *PRINTED),
            },
            reference=turned,
        ),
        *results({"(5, 6, 7) after 30° around z, of (1, 2, 3)": (AT_ONCE, (*MENDED, 1.0))}),
    ],
    errata=[
        Erratum(
            section="3.2",
            says="equation 3.4 gives x cos θ − y sin θ and x sin θ + y cos θ, with no V₁ and V₂",
            truth="the last column counts for all three: x is 4.866025, and not −0.133975",
            proof="equation 3.4, mended",
        )
    ],
)
