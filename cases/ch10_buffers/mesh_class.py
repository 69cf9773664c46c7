"""A mesh class: buffers and vertex array are made once and kept; drawing only binds them.

The constructor does the slow work: it creates the buffers, fills them, and describes the attributes
to a vertex array object. To draw is to bind that object and to call glDrawElements. So one mesh can
be drawn any number of times with different uniforms, and its buffers stay unchanged. The destructor
deletes what the constructor created: a deleted name is free, a bound buffer is unbound, and a
program in use is deleted once another one is used.

Look at: sixteen rosettes of one mesh, each drawn with an offset and a size of its own. The vertex
array is described once: stride and offsets are the same behind the last draw as behind the first.

Try: in `ch10_buffers/mesh_class.vert` write `size * (aPos.xy + offset)` for `size * aPos.xy +
offset`: the places are scaled as well, and the rosettes crowd together.
"""

from shaderlab import (
    Case,
    Erratum,
    Output,
    attribute_layout,
    cost,
    coverage,
    exact,
    gl_calls,
    query,
    value,
)
from shaderlab.engine.expectations.gl_call import Object, Program, call
from shaderlab.glslmath import swizzle, vec4

from ..scenes.api import answers, errors
from ..scenes.draws import drawn
from ..scenes.panels import picture
from ..scenes.rosette import PAPER, rosette, rosette_checks

SIDE = 4
ROSETTE = rosette(layout="interleaved")
PLACES = [((2 * k + 1) / SIDE - 1.0, (2 * j + 1) / SIDE - 1.0) for j in range(SIDE)
          for k in range(SIDE)]  # fmt: skip
# The first and the last are as large as their cells, those between them smaller and smaller.
SIZES = [(1.0 - 0.04 * (k % (len(PLACES) - 1))) / SIDE for k in range(len(PLACES))]


def window(name, meshes):
    """All sixteen, each with an offset and a size of its own, and of the mesh that is its turn."""
    shaders = ("ch10_buffers/mesh_class.vert", "ch10_buffers/rosette.frag")
    draws = (
        drawn(shaders, mesh, {"offset": place, "size": size})
        for mesh, place, size in zip(meshes, PLACES, SIZES, strict=True)
    )
    return picture(draws, (512, 512), name, clear=PAPER)


def moved(aPos, offset, size):
    """Scaled, then moved; depth stays."""
    return vec4(swizzle(aPos, "xy") * size + offset, swizzle(aPos, "z"), 1.0)


KEPT, USED = Object("buffer"), Program("kept")
IS_BUFFER, IS_PROGRAM = call("glIsBuffer", KEPT), call("glIsProgram", USED)
BOUND = call("glGetIntegerv", "GL_ARRAY_BUFFER_BINDING")
MADE = (call("glBindBuffer", "GL_ARRAY_BUFFER", KEPT),)
DELETED = (*MADE, call("glDeleteBuffers", 1, (KEPT,)))
DELETED_IN_USE = (call("glUseProgram", USED), call("glDeleteProgram", USED))
NOT_USED = (call("glUseProgram", 0),)
LIVES_ON = "a program that is deleted while it is used lives on"
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
        *answers(
            {
                "made: it is a buffer": (IS_BUFFER, "GL_TRUE", MADE),
                "deleted: none": (IS_BUFFER, "GL_FALSE", DELETED),
                "what is deleted is not bound any more": (BOUND, 0, DELETED),
                LIVES_ON: (IS_PROGRAM, "GL_TRUE", DELETED_IN_USE),
                "until another one is used": (IS_PROGRAM, "GL_FALSE", DELETED_IN_USE, NOT_USED),
            }
        ),
        *errors({"deleting 0 is no error": (call("glDeleteBuffers", 1, (0,)), "no_error")}),
        query("vertices_submitted", equals=18, pass_name="kept", name="vertices of one draw"),
        coverage(9360, pass_name="kept", draw=0, name="pixels of the first"),
        coverage(9360, pass_name="kept", draw=-1, name="pixels of the last"),
        *rosette_checks("kept", places=moved, draw=6),
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
    errata=[
        Erratum(
            section="10",
            says="a class Mesh that creates buffers and deletes none (as printed it does not "
            "compile either)",
            truth="what is created has to be deleted: a buffer stays in memory until "
            "glDeleteBuffers, whatever becomes of the C++ object",
            proof="deleted: none",
        )
    ],
)
