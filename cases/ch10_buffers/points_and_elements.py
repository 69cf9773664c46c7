"""Seven points, drawn in the order of the buffer or in the order of a list: the same picture.

glDrawArrays takes vertices as they stand, from the first to the last one. glDrawElements takes them
in the order of an index buffer, each as often as it is listed. For points that share no corners
neither is better: seven vertices go in either way, and any order of the indices will do, as long as
no point covers another one. A point is a square of gl_PointSize pixels around its vertex.

Look at: the seven squares, 24 pixels wide each: 576 pixels, 4032 together.
"""

import numpy as np

from shaderlab import (
    Case,
    Erratum,
    Mesh,
    Output,
    Target,
    exact,
    formula,
    gl_call,
    measure,
    mesh_pass,
    query,
    value,
)

from ..scenes.rosette import as_it_is, color_of, encoded, rosette

SIDE, SIZE = 256, 24.0
# Device coordinates of corners between pixels, where a square of even size covers whole pixels.
PLACES = np.array([(0, 0), (80, 0), (40, 72), (-40, 72), (-80, 0), (-40, -72), (40, -72)])
VERTICES = {
    "aPos": np.column_stack([PLACES / (SIDE / 2.0), np.zeros(7)]),
    "aColor": rosette().attributes["aColor"],
}
EVERY_THIRD = np.arange(7) * 3 % 7


def points(name, indices):
    """The seven points by arrays, or by elements where there are indices."""
    return mesh_pass(
        "ch10_buffers/points.vert",
        "ch10_buffers/rosette.frag",
        Mesh(attributes=VERTICES, indices=indices, primitive="points"),
        uniforms={"size": SIZE},
        target=Target(size=(SIDE, SIDE), clear=(0.13, 0.14, 0.17, 1.0)),
        name=name,
    )


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


case = Case(
    title="Points by arrays and by elements",
    section="10",
    math=r"\text{arrays: } v_j = j, \qquad \text{elements: } v_j = e_j, \qquad 7 \cdot 24^2 = 4032",
    passes=(*points("arrays", None), *points("elements", EVERY_THIRD)),
    picture="arrays.FragColor",
    expect=[
        exact("elements.FragColor", Output("arrays.FragColor"), name="the same picture"),
        query("vertices_submitted", equals=7, pass_name="arrays", name="vertices, arrays"),
        query("vertices_submitted", equals=7, name="vertices, elements"),
        query("samples_passed", equals=4032, name="7 squares of 24 × 24 pixels"),
        measure("pixels of the points", lit, equals=4032, digits=0),
        measure("white pixels in the middle", one_square, equals=576, digits=0),
        gl_call(
            "glIndexPointer",
            "GL_INT",
            0,
            None,
            raises="invalid_operation",
            name="glIndexPointer is gone from OpenGL's core",
        ),
        formula("gl_Position", as_it_is),
        formula("gl_PointSize", size_of),
        formula("ourColor", color_of),
        formula("FragColor", encoded),
        value(
            "FragColor", at={"ourColor": (0.25, 1.0, 0.0)}, equals=(0.5, 1.0, 0.0, 1.0), digits=6
        ),
    ],
    errata=[
        Erratum(
            section="10",
            says="with GL_ELEMENT_ARRAY_BUFFER bound, glIndexPointer says where the indices are",
            truth="it set indices of colours, in the colour-index mode that went with OpenGL 3.1; "
            "indices of vertices need no pointer but glDrawElements' own",
            proof="glIndexPointer is gone from OpenGL's core",
        )
    ],
)
