"""Rotation around x, y, z or any axis: cos φ keeps, sin φ sends across, the axis itself stays.

Around z, x becomes (cos φ, sin φ): two columns of the matrix are the places where x and y end up.
Any other axis u needs three terms: cos φ of the vector, sin φ of u × v at right angles to it, and 1
− cos φ of its part along u, which must not shrink. Turning is linear, so it leaves the origin in
its place; a translation comes after it, in the last column.

Look at: the letters, from pale to bright in three equal steps around the black arrow: by 90° around
x and y above, around z below, and by 120° around (1, 1, 1). Point your right thumb along the arrow,
and the fingers curl as the letters go. A third of a turn around (1, 1, 1) brings x to y, y to z and
z to x.
"""

from math import radians

from shaderlab import Case, Cell, Depth, Draw, Erratum, Mesh, State, computed, formula, value
from shaderlab.assets import solids
from shaderlab.assets.order import any_order
from shaderlab.glslmath import normalize
from shaderlab.reference.transforms import (
    clip_position,
    in_view,
    look_at,
    perspective,
    rotate,
    rotated,
    translate,
    world_normal,
)
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.glm import rotated_by_glm
from ..scenes.props import letter_f, tile
from ..scenes.studio import handed_on, softened, studio_color

PROJECTION = perspective(radians(38.0), 4.0 / 3.0, 0.1, 20.0)
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "any": (1, 1, 1)}
PLACES = {"x": (0, 1), "y": (1, 1), "z": (0, 0), "any": (1, 0)}
EYES = {"x": (3.6, 1.9, 2.8), "y": (1.4, 4.1, 2.3), "z": (1.2, 1.7, 4.5), "any": (2.2, 2.3, 3.9)}
STEPS = (0.0, 1.0, 2.0, 3.0)
FULL = {"x": 90.0, "y": 90.0, "z": 90.0, "any": 120.0}


def shade(step):
    """The letter, the paler the less it has turned."""
    return solids.repainted(letter_f(), (0.66, 0.69, 0.72), 0.85 * (1.0 - step / 3.0))


def quarter(name):
    """One axis: a floor, the axis as an arrow, and the letter in four positions."""
    column, row = PLACES[name]
    cell = Cell(column=column, row=row, columns=2, rows=2)
    view = look_at(EYES[name], (0.1, 0.35, 0.1))
    unit = normalize([float(a) for a in AXES[name]])
    props = (tile(1.5, 0.5), solids.arrow(1.6 * unit, color=solids.INK, thickness=0.026))
    letters = (
        Draw(
            vertex="ch03_transforms/rotate.vert",
            fragment="ch03_transforms/studio.frag",
            mesh=Mesh(**shade(step)),
            uniforms={
                "axis": AXES[name],
                "angle": radians(FULL[name] * step / 3.0),
                "offset": 0.012 * (step + 1.0) * unit,  # so that no two lie in one plane
                "view": view,
                "projection": PROJECTION,
            },
            state=State(depth=Depth(), cell=cell),
        )
        for step in STEPS
    )
    return *(stage.prop(solid, view, PROJECTION, cell=cell) for solid in props), *letters


def turned(aPos, axis, angle, offset):
    """Rodrigues's formula, then the translation."""
    return rotated(aPos, normalize(axis), angle) + offset


def turned_normal(aNormal, axis, angle):
    """Normals turn like everything else, and are not translated."""
    return rotated(aNormal, normalize(axis), angle)


def position(aPos, axis, angle, offset, view, projection):
    """Where the turned vertex lands in clip space."""
    return in_view(turned(aPos, axis, angle, offset), view, projection)


DRAWS = tuple(draw for name in AXES for draw in quarter(name))
LAST = {name: 6 * k + 5 for k, name in enumerate(AXES)}
NOTES = {"aPos": (1.0, 2.0, 3.0), "axis": (0.0, 0.0, 1.0), "angle": radians(30.0)}

case = Case(
    title="Rotation",
    section="3.2",
    math=r"R\,v = v\cos\varphi + (u \times v)\sin\varphi + u\,(u \cdot v)(1 - \cos\varphi), \qquad "
    r"R_z = \begin{pmatrix} \cos\varphi & -\sin\varphi & 0 & V_1 \\ \sin\varphi & \cos\varphi & 0 "
    r"& V_2 \\ 0 & 0 & 1 & V_3 \\ 0 & 0 & 0 & 1 \end{pmatrix}",
    passes=stage.photographed(DRAWS, (800, 600)),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        any_order("judged.FragColor"),
        *stage.prop_checks(clip_position, world_normal, handed_on, studio_color),
        *(
            formula(
                "judged.Turned",
                turned,
                draw=draw,
                also={"PyGLM": rotated_by_glm},
                name=f"{FULL[axis]:g}° around {axis}",
            )
            for axis, draw in LAST.items()
        ),
        formula("judged.Normal", turned_normal, name="normals turn"),
        formula("judged.Color", handed_on),
        formula("judged.gl_Position", position, name="clip coordinates"),
        *(
            formula("judged.FragColor", studio_color, draw=draw, name=f"colour, around {axis}")
            for axis, draw in LAST.items()
        ),
        value(
            "judged.Turned",
            at={"aPos": (1, 0, 0), "axis": (0, 0, 1), "angle": radians(90), "offset": (0, 0, 0)},
            equals=(0.0, 1.0, 0.0),
            digits=6,
            reference=turned,
            name="x becomes y",
        ),
        value(
            "judged.Turned",
            at={"aPos": (1, 0, 0), "axis": (5, 5, 5), "angle": radians(120), "offset": (0, 0, 0)},
            equals=(0.0, 1.0, 0.0),
            digits=6,
            reference=turned,
            name="a third of a turn around (5, 5, 5)",
        ),
        value(
            "judged.Turned",
            at={**NOTES, "offset": (5.0, 6.0, 7.0)},
            equals=(4.866025, 8.232051, 10.0),
            digits=6,
            reference=turned,
            name="equation 3.4, mended",
        ),
        value(
            "judged.Turned",
            at={**NOTES, "offset": (0.0, 0.0, 7.0)},
            equals=(-0.133975, 2.232051, 10.0),
            digits=6,
            reference=turned,
            name="equation 3.4, as printed",
            note="V₁ and V₂ are missing",
        ),
        computed(
            "(5, 6, 7) after 30° around z, of (1, 2, 3)",
            lambda: translate((5, 6, 7)) @ rotate(radians(30), (0, 0, 1)) @ (1, 2, 3, 1),
            equals=(4.866025, 8.232051, 10.0, 1.0),
            digits=6,
        ),
    ],
    errata=[
        Erratum(
            section="3.2",
            says="equation 3.4 gives x cos θ − y sin θ and x sin θ + y cos θ, with no V₁ and V₂: "
            "(−0.133975, 2.232051, 10, 1) for 30°, (1, 2, 3) and V = (5, 6, 7)",
            truth="the last column counts for all three: (4.866025, 8.232051, 10, 1)",
            proof="equation 3.4, mended",
        )
    ],
)
