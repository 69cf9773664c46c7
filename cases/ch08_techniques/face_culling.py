"""Face culling: which side of a triangle is seen follows from the order of its corners.

Seen from the front a triangle's corners run one way round, from behind the other way. glFrontFace
says which of the two is the front (GL_CCW by default), and glCullFace which side is dropped
(GL_BACK by default) once GL_CULL_FACE is enabled. Of a closed solid whose corners run
counter-clockwise seen from outside, every triangle that faces away is hidden by one that does not:
dropping them changes no pixel and saves half of the fragments.

Look at: the table. In the lower two rows squares run counter-clockwise, in the upper two clockwise;
of each two rows the lower one has GL_CCW for front, the upper one GL_CW. From left to right: no
culling, GL_FRONT, GL_BACK, both. Amber fields show a front face, blue ones a back face; where one
was culled the ground is seen.

Try: in `ch08_techniques/face_culling.vert` write `turned ? aPos.x : -aPos.x` for `turned ? -aPos.x
: aPos.x`: the rows of the two windings change places.
"""

import numpy as np

from shaderlab import Case, Depth, Erratum, Mesh, assets, exact, formula, query
from shaderlab.glslmath import swizzle, vec4, where
from shaderlab.reference.transforms import signed_area

from ..scenes.draws import drawn
from ..scenes.figures import results
from ..scenes.panels import cell, picture

SQUARE = Mesh(**assets.quad(1.75)).only("aPos")
# The quad of section 2.2.7: both of its triangles run clockwise.
CORNERS = np.array([(0.5, 0.5, 0.0), (0.5, -0.5, 0.0), (-0.5, -0.5, 0.0), (-0.5, 0.5, 0.0)])
QUAD = Mesh(attributes={"aPos": CORNERS}, indices=np.array([0, 1, 3, 1, 2, 3]))
CUBE = Mesh(**assets.cube()).only("aPos")
WINDINGS, FRONTS = ("ccw", "cw"), ("ccw", "cw")
CULLED = (None, "front", "back", "front_and_back")
SHADERS = "ch08_techniques/face_culling"
PAPER = (0.13, 0.14, 0.17, 1.0)
GROUND = (0.28125, 0.296875, 0.34375, 1.0)
AMBER, BLUE = (1.0, 0.625, 0.25, 1.0), (0.25, 0.5, 0.75, 1.0)


def of(column, row):
    """The cell of a field."""
    return cell(4 * row + column, 4, 4)


def field(column, row):
    """One field: a square, wound one way, with a front face and a side to be culled."""
    winding, front = divmod(row, 2)
    state = {"cull": CULLED[column], "front_face": FRONTS[front]}
    return drawn(SHADERS, SQUARE, {"turned": bool(winding)}, cell=of(column, row), **state)


def ground(column, row):
    """What a field shows where its square was culled."""
    uniforms = {"size": 1.0, "depth": 0.0, "color": GROUND}
    shaders = "ch08_techniques/framebuffer_renderbuffer"
    return drawn(shaders, SQUARE, uniforms, cell=of(column, row))


def seen(column, row):
    """What a field must show: a side, or nothing."""
    winding, front = divmod(row, 2)
    side = "front" if WINDINGS[winding] == FRONTS[front] else "back"
    if CULLED[column] in (side, "front_and_back"):
        return GROUND
    return AMBER if side == "front" else BLUE


def inner(column, row):
    """The field with its margin of paper: 64 pixels, of which the square covers 56."""
    block = np.tile(np.asarray(PAPER, np.float32), (64, 64, 1))
    block[4:60, 4:60] = seen(column, row)
    return block


# Of 4 × 4 fields the four in the middle, where the quad of 2.2.7 and the cube are.
MIDDLE = np.tile(np.asarray(PAPER), (4, 4, 1))
MIDDLE[1:3, 1:3] = AMBER
BEHIND = np.where(MIDDLE == AMBER, BLUE, MIDDLE)
CUBES = ("cube, culled", "cube, tested", "cube, culled and tested")
TABLE = [made(c, r) for made in (ground, field) for r in range(4) for c in range(4)]
TRUTH = np.block([[[inner(c, r)] for c in range(4)] for r in range(4)])


def whole(name, mesh, depth=None, **state):
    """One mesh over a window of its own."""
    side = 720 if mesh is QUAD else 64
    draw = drawn(SHADERS, mesh, {"turned": False}, depth=depth, **state)
    return picture([draw], (side, side), name, clear=PAPER, depth="depth24")


def position(aPos, turned):
    """Mirrored or not; depth the other way round than z."""
    x = where(turned > 0.5, -1.0, 1.0) * swizzle(aPos, "x")
    return vec4(x, swizzle(aPos, "y"), -swizzle(aPos, "z"), 1.0)


def whole_field(aPos, size, depth):
    """The ground reaches as far as `size`, at one depth."""
    return vec4(swizzle(aPos, "xy") * size, depth, 1.0)


def side_color(gl_FrontFacing):
    """Amber in front, blue behind."""
    return where(gl_FrontFacing > 0.5, vec4(*AMBER), vec4(*BLUE))


AREA = signed_area(CORNERS[[0, 1, 3]])

case = Case(
    title="Face culling",
    section="8.1",
    math=r"A = \tfrac12 \sum_i (x_i\,y_{i+1} - x_{i+1}\,y_i), \qquad "
    r"\text{counter-clockwise} \iff A > 0",
    passes=(
        picture(TABLE, (256, 256), "table", clear=PAPER),
        whole("back, ccw", QUAD, cull="back", front_face="ccw"),
        whole("back, cw", QUAD, cull="back", front_face="cw"),
        whole("cube", CUBE),
        whole("cube, culled", CUBE, cull="back"),
        whole("cube, culled and tested", CUBE, depth=Depth(), cull="back"),
        whole("cube, tested", CUBE, depth=Depth()),
    ),
    picture="table.FragColor",
    columns=("none", "FRONT", "BACK", "both"),
    rows=[f"{w}, front is {f}" for w in ("clockwise", "counter-clockwise") for f in ("CW", "CCW")],
    expect=[
        exact("table.FragColor", TRUTH, name="winding × front face × culled face"),
        formula("table.gl_Position", whole_field, draw=0, name="the ground of a field"),
        formula("table.gl_Position", position, draw=16),
        formula("table.gl_Position", position, draw=31, name="gl_Position, turned"),
        formula("table.FragColor", side_color, draw=16, name="colour, front"),
        formula("table.FragColor", side_color, draw=20, name="colour, back"),
        exact("back, ccw.FragColor", PAPER, name="2.2.7's quad, GL_BACK and GL_CCW"),
        exact("back, cw.FragColor", MIDDLE, name="2.2.7's quad, GL_BACK and GL_CW"),
        *(exact(f"{name}.FragColor", MIDDLE, name=f"{name}: its front") for name in CUBES),
        exact("cube.FragColor", BEHIND, name="cube: its back, which is drawn last"),
        query("samples_passed", equals=2048, pass_name="cube", name="cube: both sides, 2 · 32²"),
        query("samples_passed", equals=1024, pass_name="cube, culled", name="cube, culled: 32²"),
        query(
            "fragment_shader_invocations",
            at_least=2048,
            pass_name="cube",
            name="fragments shaded, cube",
        ),
        query(
            "fragment_shader_invocations",
            at_least=1024,
            at_most=2047,
            pass_name="cube, culled",
            name="fragments shaded, cube, culled",
        ),
        *results({"signed area of 0, 1, 3 of 2.2.7": (AREA, -0.5, "negative: clockwise")}),
    ],
    errata=[
        Erratum(
            section="8.1",
            says="to make clockwise faces the front, call glFrontFace(GL_CCW)",
            truth="GL_CCW is counter-clockwise, and the default: with it clockwise faces are "
            "back faces, and culling GL_BACK leaves nothing of them",
            proof="2.2.7's quad, GL_BACK and GL_CCW",
        )
    ],
)
