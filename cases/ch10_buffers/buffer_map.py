"""glMapBuffer: the driver hands out an address, the program writes there, and gives it back.

Instead of copying an array into a buffer, the program may have the buffer's memory appear among its
own, write to it, and unmap it before it is drawn from. glUnmapBuffer answers GL_TRUE when the
contents are safe. What is mapped is what is bound: with no buffer bound there is nothing to map,
and the call raises GL_INVALID_OPERATION (0x0502); so does mapping twice, and unmapping what is not
mapped.

Look at: the rosette. Its 168 bytes came through a pointer, and its pixels are those of a buffer
that was filled by glBufferData.
"""

from shaderlab import (
    Case,
    Output,
    Target,
    attribute_layout,
    exact,
    formula,
    gl_call,
    gl_calls,
    mesh_pass,
    value,
)
from shaderlab.expectations.gl_call import Object, call

from ..scenes.rosette import as_it_is, color_of, encoded, rosette

BUFFER = Object("buffer")
BOUND = (
    call("glBindBuffer", "GL_ARRAY_BUFFER", BUFFER),
    call("glBufferData", "GL_ARRAY_BUFFER", 168, None, "GL_STATIC_DRAW"),
)
MAP = ("glMapBuffer", "GL_ARRAY_BUFFER", "GL_WRITE_ONLY")
UNMAP = ("glUnmapBuffer", "GL_ARRAY_BUFFER")
REFUSED = "invalid_operation"


def drawn(name, upload):
    """The rosette, its buffers filled in one way or the other."""
    return mesh_pass(
        "ch10_buffers/rosette.vert",
        "ch10_buffers/rosette.frag",
        rosette(layout="batched", upload=upload),
        target=Target(size=(512, 512), clear=(0.13, 0.14, 0.17, 1.0)),
        name=name,
    )


case = Case(
    title="Writing through a mapping",
    section="10",
    math=r"168 = 7 \cdot (3 + 3) \cdot 4\ \text{bytes}, \qquad "
    r"\text{map} \to \text{write} \to \text{unmap} = \mathtt{GL\_TRUE}",
    passes=(*drawn("copied", "data"), *drawn("mapped", "map")),
    expect=[
        exact("mapped.FragColor", Output("copied.FragColor"), name="same pixels as copied"),
        gl_calls("glMapBufferRange", access="GL_MAP_WRITE_BIT", length=168, times=1, name="mapped"),
        gl_calls("glUnmapBuffer", times=1, pass_name="mapped", after="glMapBufferRange"),
        gl_calls("glBufferSubData", times=0, pass_name="mapped", name="nothing else is written"),
        gl_call(*MAP, raises=REFUSED, name="map with buffer 0 bound: 0x0502"),
        gl_call(*MAP, before=BOUND, name="map with a buffer bound"),
        gl_call(*MAP, before=(*BOUND, call(*MAP)), raises=REFUSED, name="map what is mapped"),
        gl_call(*UNMAP, before=(*BOUND, call(*MAP)), returns="GL_TRUE", name="unmap"),
        gl_call(*UNMAP, before=BOUND, raises=REFUSED, name="unmap what is not mapped"),
        gl_call(
            "glGetBufferParameteriv",
            "GL_ARRAY_BUFFER",
            "GL_BUFFER_SIZE",
            before=BOUND,
            returns=168,
            name="size of the buffer",
        ),
        attribute_layout({"aPos": (0, 12), "aColor": (84, 12)}, name="positions, then colours"),
        formula("gl_Position", as_it_is),
        formula("ourColor", color_of),
        formula("FragColor", encoded),
        value("FragColor", at={"ourColor": (0.25, 1, 0)}, equals=(0.5, 1, 0, 1), digits=6),
    ],
)
