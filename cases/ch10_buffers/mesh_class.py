"""A mesh class: buffers and vertex array are made once and kept; drawing only binds them.

The constructor does the slow work: it creates the buffers, fills them, and describes the attributes
to a vertex array object. To draw is to bind that object and to call glDrawElements. So one mesh can
be drawn any number of times with different uniforms, and its buffers stay unchanged. The destructor
deletes what the constructor created: a deleted name is free, a bound buffer is unbound, and a
program in use is deleted once another one is used.

Look at: sixteen clown fish of one mesh, each drawn with an offset and a size of its own. The vertex
array is described once: stride and offsets are the same after the last draw as after the first.

Try: in `ch10_buffers/mesh_class.vert` write `size * (aPos.xy + offset)` for `size * aPos.xy +
offset`: the places are scaled as well, and the shoal crowds together.
"""

from shaderlab import Case, Erratum, Output, attribute_layout, cost, exact, gl_call, query, value
from shaderlab.engine.expectations.gl_call import Object, Program, call
from shaderlab.glslmath import swizzle, vec4

from ..scenes.api import answers, errors, sent
from ..scenes.draws import drawn
from ..scenes.flat_figures import fish, pictured, pictured_checks
from ..scenes.panels import picture
from ..scenes.rosette import rosette_checks

SEA = (0.10, 0.38, 0.52, 1.0)
FISH, *SIXTEEN = (fish(layout="interleaved") for _ in range(17))
# Row by row from above, the smallest first: the nearest fish are drawn last.
PLACES = [(0.45 * k - 0.75 + 0.12 * (row % 2), 0.74 - 0.48 * row + 0.07 * (k % 3))
          for row in range(4) for k in range(4)]  # fmt: skip
SIZES = [0.1 + 0.01 * k for k in range(len(PLACES))]


def shoal(meshes):
    """All sixteen, each with an offset and a size of its own, and of the mesh that is its turn."""
    shaders = ("ch10_buffers/mesh_class.vert", "ch10_buffers/rosette.frag")
    return [
        drawn(shaders, mesh, {"offset": place, "size": size})
        for mesh, place, size in zip(meshes, PLACES, SIZES, strict=True)
    ]


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
CORNER = {"aPos": (0.5, -0.5, 0.25), "offset": (0.125, 0.25), "size": 0.5}
LAYOUT = {"aPos": (0, 24), "aColor": (12, 24)}

case = Case(
    title="A mesh that is kept",
    section="10",
    math=r"\mathbf{q}_{k,i} = (s\,x_i + o_{k,x},\; s\,y_i + o_{k,y},\; z_i,\; 1), \qquad "
    r"k = 0 \ldots 15",
    passes=(
        *pictured(shoal([fish()] * 16), (640, 640), SEA),
        picture(shoal([FISH] * 16), (512, 512), "kept", clear=SEA),
        picture(shoal(SIXTEEN), (512, 512), "made anew", clear=SEA),
    ),
    picture="picture.FragColor",
    expect=[
        exact("kept.FragColor", Output("made anew.FragColor"), name="same as 16 meshes"),
        attribute_layout(LAYOUT, pass_name="kept", draw=0, name="layout, first draw"),
        attribute_layout(LAYOUT, pass_name="kept", draw=-1, name="layout, last draw"),
        *sent("kept", {"one vertex array for all": ("glGenVertexArrays", 1)}),
        *sent("made anew", {"or one for each": ("glGenVertexArrays", 16)}),
        *answers(
            {
                "made: it is a buffer": (IS_BUFFER, "GL_TRUE", MADE),
                "deleted: none": (IS_BUFFER, "GL_FALSE", DELETED),
                "what is deleted is not bound any more": (BOUND, 0, DELETED),
                LIVES_ON: (IS_PROGRAM, "GL_TRUE", DELETED_IN_USE),
                "until another one is used": (IS_PROGRAM, "GL_FALSE", DELETED_IN_USE, NOT_USED),
            }
        ),
        gl_call(BOUND.function, *BOUND.arguments, before=MADE, at_least=1, name="made: bound"),
        *errors({"deleting 0 is no error": (call("glDeleteBuffers", 1, (0,)), "no_error")}),
        query("vertices_submitted", equals=87, pass_name="kept", name="vertices of one draw"),
        *pictured_checks(),
        *rosette_checks("kept", places=moved, draw=6),
        value("kept.gl_Position", at=CORNER, equals=(0.375, 0.0, 0.25, 1.0), digits=6),
        cost(
            {"kept": {16: "kept"}, "made anew": {16: "made anew"}},
            draw_calls={"kept": lambda n: n, "made anew": lambda n: n},
            vertices={"kept": lambda n: 87 * n, "made anew": lambda n: 87 * n},
            over="fish",
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
