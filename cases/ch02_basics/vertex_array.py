"""No vertex array, no picture: the core profile draws nothing without one.

A vertex array object stores what the attribute calls set: which buffer each attribute is read from,
at which stride and offset, and which attributes are enabled. Every draw uses the one that is bound.
In the compatibility profile there is one by default, number 0; in the core profile number 0 is not
an object, and a draw call only raises GL_INVALID_OPERATION (0x0502) and writes no pixel. Only
glGetError, or a debug callback, tells why the window is empty.

Look at: the triangle, drawn with its vertex array bound. The same draw without one is the other
pass, "nothing bound": its window is as it was cleared.

Try: in `ch02_basics/vertex_array.vert` write `aPos.x + 0.5` for `aPos.y + 0.5`: the colour changes
from left to right.
"""

import numpy as np

from shaderlab import Case, Draw, Mesh, coverage, exact, formula, gl_error, measure, query, value
from shaderlab.engine.expectations.gl_call import Object, call
from shaderlab.glslmath import mix, swizzle, vec3, vec4

from ..scenes.api import answers, errors, in_use, pixel
from ..scenes.laws import device_place
from ..scenes.objects import array_of_point
from ..scenes.panels import picture

TRIANGLE = Mesh(attributes={"aPos": np.array([(-0.5, -0.5, 0), (0.5, -0.5, 0), (0, 0.5, 0)])})
PAPER = (0.93, 0.93, 0.92, 1.0)


def drawn(name, bound):
    """The triangle, with its vertex array or with none."""
    draw = Draw(
        vertex="ch02_basics/vertex_array.vert",
        fragment="ch02_basics/vertex_array.frag",
        mesh=TRIANGLE,
        vertex_array=bound,
    )
    return picture([draw], (720, 720), name, clear=PAPER)


def above_the_foot(aPos):
    """How high a corner is."""
    return swizzle(aPos, "y") + 0.5


def sunset(height):
    """From blue at the foot to amber at the tip."""
    return vec4(mix(vec3(0.16, 0.42, 0.55), vec3(1.0, 0.72, 0.30), height), 1.0)


def off_paper(FragColor):
    """How far what lies beside the triangle is from the colour that it was cleared to."""
    beside = np.ones(FragColor.shape[:2], bool)
    beside[180:540, 180:540] = False
    return np.abs(FragColor[beside] - PAPER).max()


LOW, HIGH = (94, 126, 124), (201, 164, 92)  # the colours at a quarter and at three quarters
INDICES = call("glGetBufferParameteriv", "GL_ELEMENT_ARRAY_BUFFER", "GL_BUFFER_SIZE")
ARRAY = Object("vertex_array", "low")
IS_ARRAY, AGAIN = call("glIsVertexArray", ARRAY), (call("glBindVertexArray", ARRAY),)
BOTH = *array_of_point("low", (0, -0.25, 0)), *array_of_point("higher", (0, 0.25, 0))
DELETED, USED = (call("glDeleteVertexArrays", 1, (ARRAY,)),), (*in_use(), *BOTH)
DRAW = call("glDrawArrays", "GL_POINTS", 0, 1)

case = Case(
    title="The vertex array",
    section="2.2.2",
    math=r"\text{address of attribute } a \text{ of vertex } i = o_a + s_a\, i, \qquad "
    r"\text{array } 0 \Rightarrow \mathtt{0x0502}",
    passes=(drawn("nothing bound", False), drawn("bound", True)),
    expect=[
        gl_error("invalid_operation", pass_name="nothing bound", name="nothing bound: 0x0502"),
        exact("nothing bound.FragColor", PAPER, name="nothing bound: nothing drawn"),
        gl_error("no_error", name="bound: no error"),
        coverage(64800, name="bound: pixels covered"),
        measure(
            "bound: the paper around it",
            off_paper,
            reads={"FragColor": "bound.FragColor"},
            at_most=2.0**-24,
        ),
        query("vertices_submitted", equals=3, name="bound: three vertices"),
        formula("gl_Position", device_place),
        formula("height", above_the_foot),
        formula("FragColor", sunset),
        *answers(
            {
                "the array bound last is drawn": pixel(HIGH, BOTH),
                "bound again, the first is drawn": pixel(LOW, BOTH, AGAIN),
                "each array has its own index buffer": (INDICES, 6, BOTH),
                "bound again, the first has its own": (INDICES, 3, BOTH, AGAIN),
                "a bound array is one": (IS_ARRAY, "GL_TRUE", BOTH),
                "a deleted array is none": (IS_ARRAY, "GL_FALSE", BOTH, DELETED),
            }
        ),
        *errors({"deleted, it draws nothing": (DRAW, "invalid_operation", USED, AGAIN, DELETED)}),
        value("FragColor", at={"height": 0.5}, equals=(0.58, 0.57, 0.425, 1.0), digits=6),
    ],
)
