"""Four vertices, two triangles: an index buffer lets triangles share corners.

The indices 0, 1, 3 and 1, 2, 3 name each triangle's corners. The quad looks exactly as if all six
corners had been sent, but the vertex shader need run on four only.

Look at: the shared edge, which has neither a gap nor a pixel drawn twice: 129600 of 720 × 720
pixels are a quarter of the window. And at the order of the corners: both triangles run clockwise,
so with OpenGL's default front face (counter-clockwise) culling back faces leaves nothing at all.

Try: in `ch02_basics/indexed_quad.vert` write `vec4((1.0 + 0.2 * float(gl_VertexID)) * aPos, 1.0)`
for `vec4(aPos, 1.0)`: each corner moves outward by its number. Both triangles stay together,
because they share two of them.
"""

import numpy as np

from shaderlab import Case, Mesh, Output, State, Target, coverage, exact, formula, mesh_pass
from shaderlab.engine.expectations.gl_call import Object, call
from shaderlab.glslmath import swizzle, vec4, where
from shaderlab.reference.transforms import signed_area

from ..scenes.api import answers, in_use
from ..scenes.figures import results
from ..scenes.laws import device_place
from ..scenes.objects import shader_runs_counted

CORNERS = np.array([(0.5, 0.5, 0.0), (0.5, -0.5, 0.0), (-0.5, -0.5, 0.0), (-0.5, 0.5, 0.0)])
INDICES = np.array([0, 1, 3, 1, 2, 3])
AREAS = [signed_area(CORNERS[INDICES[first : first + 3]]) for first in (0, 3)]
CLOCKWISE = "negative: clockwise"
CLEAR = (0.2, 0.3, 0.3, 1.0)

INDEXED = Mesh(attributes={"aPos": CORNERS}, indices=INDICES)
PLAIN = Mesh(attributes={"aPos": CORNERS[INDICES]})


def drawn(name, mesh, **state):
    """One pass over the whole window with this mesh and this fixed-function state."""
    return mesh_pass(
        "ch02_basics/indexed_quad.vert",
        "ch02_basics/indexed_quad.frag",
        mesh,
        name=name,
        target=Target(size=(720, 720), clear=CLEAR),
        state=State(**state),
    )


def across_the_quad(aPos):
    """A corner's x and y, handed on."""
    return swizzle(aPos, "xy")


def two_triangles(place):
    """Amber above the shared edge, teal below it."""
    above = swizzle(place, "x") + swizzle(place, "y") > 0.0
    return where(above, vec4(1.0, 0.625, 0.25, 1.0), vec4(0.25, 0.625, 0.625, 1.0))


RUNS = call("glGetQueryObjectuiv", Object("query"), "GL_QUERY_RESULT")
ARRAYS = (call("glDrawArrays", "GL_TRIANGLES", 0, 6),)
ELEMENTS = (
    call("glBindBuffer", "GL_ELEMENT_ARRAY_BUFFER", Object("buffer")),
    call("glBufferData", "GL_ELEMENT_ARRAY_BUFFER", 6, bytes(INDICES.tolist()), "GL_STATIC_DRAW"),
    call("glDrawElements", "GL_TRIANGLES", 6, "GL_UNSIGNED_BYTE", 0),
)
WITH_INDICES = shader_runs_counted(ELEMENTS)

case = Case(
    title="An indexed quad",
    section="2.2.7",
    math=r"A = \tfrac12 \sum_i (x_i\,y_{i+1} - x_{i+1}\,y_i)",
    passes=(
        *drawn("indexed", INDEXED),
        *drawn("plain", PLAIN),
        *drawn("cull-back", INDEXED, cull="back", front_face="ccw"),
        *drawn("cull-back-cw", INDEXED, cull="back", front_face="cw"),
    ),
    picture="indexed.FragColor",
    expect=[
        coverage(129600, pass_name="indexed", name="pixels covered"),
        formula("indexed.gl_Position", device_place, name="corners are device coordinates"),
        formula("indexed.place", across_the_quad),
        exact("cull-back.FragColor", CLEAR, name="culled, nothing is left"),
        exact("cull-back-cw.FragColor", Output("indexed.FragColor"), name="clockwise is the front"),
        formula("indexed.FragColor", two_triangles, name="one colour a triangle"),
        exact("indexed.FragColor", Output("plain.FragColor"), name="same as six vertices"),
        *answers(
            {
                "the vertex shader runs four times": (RUNS, 4, in_use(), WITH_INDICES),
                "… six times without indices": (RUNS, 6, in_use(), shader_runs_counted(ARRAYS)),
            }
        ),
        coverage(0, pass_name="cull-back", name="culled when counter-clockwise is front"),
        coverage(129600, pass_name="cull-back-cw", name="kept when clockwise is front"),
        *results({"signed area of 0, 1, 3": (AREAS[0], -0.5, CLOCKWISE)}),
        *results({"signed area of 1, 2, 3": (AREAS[1], -0.5, CLOCKWISE)}),
    ],
)
