"""Seven points, drawn in the order of the buffer or in the order of a list: the same picture.

glDrawArrays takes vertices as they stand, from the first to the last one. glDrawElements takes them
in the order of an index buffer, each as often as it is listed. For points, which share no corners,
neither is better: both draw seven vertices, and any order of the indices will do, as long as no
point covers another. An index is an unsigned byte, short or int; signed types are not allowed. A
point is a square of gl_PointSize pixels around its vertex.

Look at: the seven stars of the Plough, squares of 24 pixels: 576 pixels each, 4032 together. They
are the same on both sides. A line strip of the same vertices runs through them: on the left in the
order of the buffer, along the handle and around the bowl, on the right in that of a list of seven
bytes, which takes every third one.

Try: in `ch10_buffers/points.vert` write `PointSize = size * (0.4 + 0.2 * float(gl_VertexID))` for
`PointSize = size`: points grow with their number in the buffer, on both sides alike, in whatever
order they are drawn.
"""

import numpy as np

from shaderlab import Case, Erratum, Mesh, Output, exact, formula, gl_calls, measure, query
from shaderlab.engine.expectations.gl_call import Object, Program, call

from ..scenes.api import PIXEL, answers, errors, in_use
from ..scenes.draws import drawn
from ..scenes.figures import each_draw
from ..scenes.laws import device_place
from ..scenes.panels import cell, picture
from ..scenes.rosette import color_of, encoded, rosette_checks

SIDE, SIZE = 256, 24.0
NIGHT = (0.03, 0.05, 0.12, 1.0)
# Device coordinates of corners between pixels, where a square of even size covers whole pixels.
# From the handle's end to the bowl's; the star where they meet is in the middle, and white.
PLACES = np.array([(-112, 44), (-76, 66), (-38, 36), (0, 0), (16, -78), (98, -70), (92, 30)])
STARS = [(0.6, 0.8, 1.0), (1.0, 0.9, 0.7), (0.7, 0.9, 1.0), (1.0, 1.0, 1.0), (0.8, 0.9, 1.0),
         (1.0, 0.95, 0.8), (1.0, 0.6, 0.25)]  # fmt: skip
VERTICES = {
    "aPos": np.column_stack([PLACES / (SIDE / 2.0), np.zeros(7)]),
    "aColor": np.array(STARS),
}
EVERY_THIRD = np.arange(7) * 3 % 7
BYTES = EVERY_THIRD.astype(np.uint8)
SHOWN = ("lines by arrays", "points by arrays", "lines by bytes", "points by bytes")


def through(indices, primitive="points", **state):
    """The seven vertices by arrays, or by elements where there are indices."""
    mesh = Mesh(attributes=VERTICES, indices=indices, primitive=primitive)
    shaders = ("ch10_buffers/points.vert", "ch10_buffers/rosette.frag")
    return drawn(shaders, mesh, {"size": SIZE}, **state)


def window(name, *draws, wide=1):
    """One of the windows, or two side by side."""
    return picture(draws, (wide * SIDE, SIDE), name, clear=NIGHT)


def size_of(size):
    """Each point's size is the uniform's."""
    return size


def lit(FragColor):
    """Pixels that a point covers: all points have a channel of 1."""
    return np.count_nonzero(FragColor[..., :3].max(axis=-1) == 1.0)


def square(row, column):
    """Rows and columns of a block, as its lower left pixel and its size say."""
    return (slice(row, row + 24), slice(column, column + 24))


def one_square(FragColor):
    """Pixels of the block around the window's middle that are white."""
    return np.count_nonzero((FragColor[square(116, 116)] == 1.0).all(axis=-1))


# Three points in one place in as many colours, and indices of a byte each.
INDEXED = (
    *in_use(Program("arrays")),
    call("glBindBuffer", "GL_ARRAY_BUFFER", Object("buffer", "colours")),
    call(
        "glBufferData",
        *("GL_ARRAY_BUFFER", 12, bytes((255, 0, 0, 0, 255, 0, 0, 0, 0, 255, 255, 0))),
        "GL_STATIC_DRAW",
    ),
    call("glVertexAttribPointer", 1, 3, "GL_UNSIGNED_BYTE", "GL_TRUE", 4, 0),
    call("glEnableVertexAttribArray", 1),
    call("glBindBuffer", "GL_ELEMENT_ARRAY_BUFFER", Object("buffer", "indices")),
    call(
        "glBufferData",
        *("GL_ELEMENT_ARRAY_BUFFER", 28, bytes((0, 0, 0, 2)) + bytes(24), "GL_STATIC_DRAW"),
    ),
)

THIRD = (*INDEXED, call("glDrawElements", "GL_POINTS", 1, "GL_UNSIGNED_BYTE", 3))
CYAN = (0, 255, 255, 255)
REMOVED = {
    "glBegin": ("GL_TRIANGLES",), "glEnd": (), "glArrayElement": (0,),
    "glVertexPointer": (3, "GL_FLOAT", 0, None), "glColorPointer": (3, "GL_FLOAT", 0, None),
    "glEnableClientState": ("GL_VERTEX_ARRAY",),
}  # fmt: skip
GONE = "glIndexPointer is gone from OpenGL's core"

case = Case(
    title="Points by arrays and by elements",
    section="10",
    math=r"\text{arrays: } v_j = j, \qquad \text{elements: } v_j = e_j, \qquad 7 \cdot 24^2 = 4032",
    passes=(
        window("arrays", through(None)),
        window("bytes", through(BYTES)),
        window(
            "picture",
            *(
                through(indices, primitive, cell=cell(k, 2))
                for k, indices in enumerate((None, BYTES))
                for primitive in ("line_strip", "points")
            ),
            wide=2,
        ),
        window("elements", through(EVERY_THIRD)),
    ),
    picture="picture.FragColor",
    columns=("glDrawArrays", "glDrawElements"),
    expect=[
        *each_draw("picture.FragColor", encoded, enumerate(SHOWN)),
        *each_draw("picture.ourColor", color_of, enumerate(f"{name}: colours" for name in SHOWN)),
        *each_draw("picture.gl_Position", device_place, enumerate(f"{n}: places" for n in SHOWN)),
        exact("bytes.FragColor", Output("arrays.FragColor"), name="bytes: the same picture"),
        gl_calls(
            "glDrawElementsInstanced",
            type="GL_UNSIGNED_BYTE",
            count=7,
            times=1,
            pass_name="bytes",
            name="seven indices of a byte",
        ),
        exact("elements.FragColor", Output("arrays.FragColor"), name="the same picture"),
        query("vertices_submitted", equals=7, pass_name="arrays", name="vertices, arrays"),
        query("vertices_submitted", equals=7, name="vertices, elements"),
        query("samples_passed", equals=4032, name="7 squares of 24 × 24 pixels"),
        measure("pixels of the points", lit, equals=4032, digits=0),
        measure("white pixels in the middle", one_square, equals=576, digits=0),
        *errors(
            {
                GONE: (call("glIndexPointer", "GL_INT", 0, None), "invalid_operation"),
                **{
                    f"{name} is gone from OpenGL's core": (call(name, *given), "invalid_operation")
                    for name, given in REMOVED.items()
                },
                "glEnable(GL_TEXTURE_2D) is gone as well": (
                    call("glEnable", "GL_TEXTURE_2D"),
                    "invalid_enum",
                ),
                **{
                    f"indices of GL_{kind}": (
                        call("glDrawElements", "GL_POINTS", 7, f"GL_{kind}", 0),
                        raises,
                        INDEXED,
                    )
                    for kind, raises in (
                        ("UNSIGNED_SHORT", "no_error"),
                        ("BYTE", "invalid_enum"),
                        ("FLOAT", "invalid_enum"),
                    )
                },
            },
            {"glArrayElement is gone from OpenGL's core": {"NVIDIA": "GL_NO_ERROR"}},
        ),
        *answers({"the fourth byte is the index 2, whose colour is cyan": (PIXEL, CYAN, THIRD)}),
        formula("gl_PointSize", size_of),
        *rosette_checks(),
    ],
    errata=[
        Erratum(
            section="10",
            says="with GL_ELEMENT_ARRAY_BUFFER bound, glIndexPointer says where the indices are",
            truth="it set indices of colours, in the colour-index mode that went with OpenGL 3.1; "
            "indices of vertices need no pointer but glDrawElements' own",
            proof=GONE,
        )
    ],
)
