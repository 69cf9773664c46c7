"""glMapBuffer: the driver hands out an address, the program writes there, and gives it back.

Instead of copying an array into a buffer, the program may have the buffer's memory appear among its
own, write to it, and unmap it before it is drawn from. glUnmapBuffer answers GL_TRUE when the
contents are safe. What is mapped is what is bound: with no buffer bound there is nothing to map,
and the call raises GL_INVALID_OPERATION (0x0502); so does mapping twice, and unmapping what is not
mapped.

Look at: the rosette. Its 168 bytes came through a pointer, and its pixels are those of a buffer
that was filled by glBufferData.
"""

from shaderlab import Case, Output, attribute_layout, exact, gl_call, gl_calls
from shaderlab.expectations.gl_call import Object, call

from ..scenes.api import answers
from ..scenes.rosette import rosette_checks, window

BUFFER = Object("buffer")
BOUND = (
    call("glBindBuffer", "GL_ARRAY_BUFFER", BUFFER),
    call("glBufferData", "GL_ARRAY_BUFFER", 168, None, "GL_STATIC_DRAW"),
)
MAP = ("glMapBuffer", "GL_ARRAY_BUFFER", "GL_WRITE_ONLY")
UNMAP = ("glUnmapBuffer", "GL_ARRAY_BUFFER")
REFUSED = "invalid_operation"


SIZE = call("glGetBufferParameteriv", "GL_ARRAY_BUFFER", "GL_BUFFER_SIZE")

case = Case(
    title="Writing through a mapping",
    section="10",
    math=r"168 = 7 \cdot (3 + 3) \cdot 4\ \text{bytes}, \qquad "
    r"\text{map} \to \text{write} \to \text{unmap} = \mathtt{GL\_TRUE}",
    passes=(
        window("copied", layout="batched", upload="data"),
        window("mapped", layout="batched", upload="map"),
    ),
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
        *answers({"size of the buffer": (SIZE, 168, BOUND)}),
        attribute_layout({"aPos": (0, 12), "aColor": (84, 12)}, name="positions, then colours"),
        *rosette_checks(),
    ],
)
