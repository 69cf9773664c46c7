"""A mesh class: buffers and vertex array are made once and kept; drawing only binds them.

The constructor does what is slow: it makes the buffers, fills them, and describes the attributes to
a vertex array object. To draw is to bind that object and to call glDrawElements. So one mesh is
drawn as often as one likes, each time with other uniforms; what is in its buffers stays as it was.
The destructor deletes what the constructor made: a name that is deleted is free, a buffer that was
bound is so no more, and a program that is in use goes when another one is used.

Look at: sixteen rosettes of one mesh, each drawn with an offset of its own. The vertex array is
described once: stride and offsets are the same behind the last draw as behind the first.
"""

from shaderlab import (
    Case,
    Draw,
    Output,
    Pass,
    Target,
    attribute_layout,
    cost,
    coverage,
    exact,
    formula,
    gl_call,
    gl_calls,
    query,
    value,
)
from shaderlab.expectations.gl_call import Object, Program, call
from shaderlab.glslmath import swizzle, vec4

from ..scenes.rosette import color_of, encoded, rosette

SIDE = 4
ROSETTE = rosette(layout="interleaved")
PLACES = [((2 * k + 1) / SIDE - 1.0, (2 * j + 1) / SIDE - 1.0) for j in range(SIDE)
          for k in range(SIDE)]  # fmt: skip
PAPER = (0.13, 0.14, 0.17, 1.0)


def drawn(mesh, place):
    """One rosette, a quarter as large as the window."""
    return Draw(
        vertex="ch10_buffers/mesh_class.vert",
        fragment="ch10_buffers/rosette.frag",
        mesh=mesh,
        uniforms={"offset": place, "size": 1.0 / SIDE},
    )


def window(name, meshes):
    """All sixteen, each of the mesh that is its turn."""
    draws = tuple(drawn(mesh, place) for mesh, place in zip(meshes, PLACES, strict=True))
    return Pass(name=name, target=Target(size=(512, 512), clear=PAPER), draws=draws)


def moved(aPos, offset, size):
    """Scaled, then moved; depth stays."""
    return vec4(swizzle(aPos, "xy") * size + offset, swizzle(aPos, "z"), 1.0)


KEPT, USED = Object("buffer"), Program("kept")
MADE = (call("glBindBuffer", "GL_ARRAY_BUFFER", KEPT),)
DELETE = call("glDeleteBuffers", 1, (KEPT,))
LAYOUT = {"aPos": (0, 24), "aColor": (12, 24)}

case = Case(
    title="A mesh that is kept",
    section="10",
    math=r"\mathbf{q}_{k,i} = (s\,x_i + o_{k,x},\; s\,y_i + o_{k,y},\; z_i,\; 1), \qquad "
    r"k = 0 \ldots 15",
    passes=(
        window("kept", [ROSETTE] * SIDE**2),
        window("made anew", [rosette(layout="interleaved") for _ in PLACES]),
    ),
    picture="kept.FragColor",
    expect=[
        exact("kept.FragColor", Output("made anew.FragColor"), name="same as 16 meshes"),
        attribute_layout(LAYOUT, pass_name="kept", draw=0, name="layout, first draw"),
        attribute_layout(LAYOUT, pass_name="kept", draw=-1, name="layout, last draw"),
        gl_calls("glGenVertexArrays", times=1, pass_name="kept", name="one vertex array for all"),
        gl_calls("glGenVertexArrays", times=16, pass_name="made anew", name="or one for each"),
        gl_call("glIsBuffer", KEPT, before=MADE, returns="GL_TRUE", name="made: it is a buffer"),
        gl_call(
            "glIsBuffer", KEPT, before=(*MADE, DELETE), returns="GL_FALSE", name="deleted: none"
        ),
        gl_call(
            "glGetIntegerv",
            "GL_ARRAY_BUFFER_BINDING",
            before=(*MADE, DELETE),
            returns=0,
            name="what is deleted is not bound any more",
        ),
        gl_call(
            "glIsProgram",
            USED,
            before=(call("glUseProgram", USED), call("glDeleteProgram", USED)),
            returns="GL_TRUE",
            name="a program that is deleted while it is used lives on",
        ),
        gl_call(
            "glIsProgram",
            USED,
            before=(
                call("glUseProgram", USED),
                call("glDeleteProgram", USED),
                call("glUseProgram", 0),
            ),
            returns="GL_FALSE",
            name="until another one is used",
        ),
        gl_call("glDeleteBuffers", 1, (0,), name="deleting 0 is no error"),
        query("vertices_submitted", equals=18, pass_name="kept", name="vertices of one draw"),
        coverage(9360, pass_name="kept", draw=0, name="pixels of the first"),
        coverage(9360, pass_name="kept", draw=-1, name="pixels of the last"),
        formula("kept.gl_Position", moved, draw=6),
        formula("kept.ourColor", color_of, draw=6),
        formula("kept.FragColor", encoded, draw=6),
        value("kept.FragColor", at={"ourColor": (0.25, 1, 0)}, equals=(0.5, 1, 0, 1), digits=6),
        value(
            "kept.gl_Position",
            at={"aPos": (0.5, -0.5, 0.25), "offset": (0.125, 0.25), "size": 0.5},
            equals=(0.375, 0.0, 0.25, 1.0),
            digits=6,
        ),
        cost(
            {"kept": {16: "kept"}, "made anew": {16: "made anew"}},
            draw_calls={"kept": lambda n: n, "made anew": lambda n: n},
            vertices={"kept": lambda n: 18 * n, "made anew": lambda n: 18 * n},
            over="rosettes",
            name="cost of drawing",
        ),
    ],
)
