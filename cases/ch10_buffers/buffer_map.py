"""glMapBuffer: the driver hands out an address, the program writes there, and gives it back.

Instead of copying an array into a buffer, the program can map the buffer into its own memory, write
to it, and unmap it before drawing. glUnmapBuffer answers GL_TRUE when the contents are safe. What
is mapped is what is bound: with no buffer bound there is nothing to map, and the call raises
GL_INVALID_OPERATION (0x0502); so does mapping twice, and unmapping what is not mapped. While it is
mapped, OpenGL may neither read nor write the contents. A mapping is for reading, for writing or for
both; one for writing may discard the old contents, so that the driver need not wait.

Pixels can be written so, too. While a buffer is bound as GL_PIXEL_UNPACK_BUFFER, glTexImage2D takes
its image from there, and its last argument is an offset into the buffer. Films, and anything else
that the processor draws for each frame, reach the screen this way.

Look at: a Julia set of z² + c, computed by the processor, texel by texel, and written through a
pointer. The rosette's 168 bytes came through one as well. The pixels of both are those of contents
that were copied.
"""

import numpy as np

from shaderlab import Case, Erratum, Output, Texture, attribute_layout, exact, formula, gl_call
from shaderlab.engine.expectations.gl_call import Object, call

from ..scenes.api import answers, errors, sent
from ..scenes.laws import sampled
from ..scenes.panels import WHOLE, panel_pass
from ..scenes.rosette import rosette_checks, window

BUFFER = Object("buffer")
BOUND = (
    call("glBindBuffer", "GL_ARRAY_BUFFER", BUFFER),
    call("glBufferData", "GL_ARRAY_BUFFER", 168, None, "GL_STATIC_DRAW"),
)
MAP = ("glMapBuffer", "GL_ARRAY_BUFFER")
TO_WRITE = (*MAP, "GL_WRITE_ONLY")
RANGE = ("glMapBufferRange", "GL_ARRAY_BUFFER", 0)
ACCESS = call("glGetBufferParameteriv", "GL_ARRAY_BUFFER", "GL_BUFFER_ACCESS")
IS_MAPPED = call("glGetBufferParameteriv", "GL_ARRAY_BUFFER", "GL_BUFFER_MAPPED")
SIZE = call("glGetBufferParameteriv", "GL_ARRAY_BUFFER", "GL_BUFFER_SIZE")
WRITTEN = call("glBufferSubData", "GL_ARRAY_BUFFER", 0, 4, bytes(4))
READ, WRITE, GIVE_UP = "GL_MAP_READ_BIT", "GL_MAP_WRITE_BIT", "GL_MAP_INVALIDATE_BUFFER_BIT"
UNMAP = ("glUnmapBuffer", "GL_ARRAY_BUFFER")
MAPPED, READ_WRITTEN = (*BOUND, call(*TO_WRITE)), call(*MAP, "GL_READ_WRITE")
REFUSED = "invalid_operation"
UNBOUND = "map with buffer 0 bound: 0x0502"
IMAGE = {"width": 480, "height": 320, "internalformat": "GL_RGBA8", "pixels": "NULL"}
BYTES = {"access": "GL_MAP_WRITE_BIT", "length": 168}


def julia():
    """How soon |z² + c| passes 2, for c = −0.8 + 0.156i and z in ±1.56 and ±1.04i, as colours."""
    z = np.linspace(-1.56, 1.56, 480) + 1j * np.linspace(-1.04, 1.04, 320)[:, None]
    steps = np.zeros(z.shape)
    for _ in range(96):
        inside = np.abs(z) <= 2.0
        z = np.where(inside, z * z + (-0.8 + 0.156j), z)
        steps += inside
    light = (steps / 96.0)[..., None] ** (1.2, 0.75, 0.42, 0.0)
    return (255.0 * light).astype(np.uint8)


def shown(name, upload):
    """The Julia set, each texel on a pixel, after one way of filling its texture."""
    image = {"image": Texture(image=julia, format="rgba8", upload=upload)}
    return panel_pass(name, "ch02_basics/textured.frag", WHOLE, size=(480, 320), textures=image)


case = Case(
    title="Writing through a mapping",
    section="10",
    math=r"168 = 7 \cdot (3 + 3) \cdot 4\ \text{bytes}, \qquad "
    r"\text{map} \to \text{write} \to \text{unmap} = \mathtt{GL\_TRUE}",
    passes=(
        window("copied", layout="batched", upload="data"),
        shown("picture, copied", "data"),
        shown("picture", "map"),
        window("mapped", layout="batched", upload="map"),
    ),
    picture="picture.FragColor",
    expect=[
        exact("mapped.FragColor", Output("copied.FragColor"), name="same pixels as copied"),
        *sent(None, {"mapped": ("glMapBufferRange", 1, BYTES)}),
        *sent("mapped", {"and unmapped": ("glUnmapBuffer", 1, {"after": "glMapBufferRange"})}),
        *sent("mapped", {"nothing else is written": ("glBufferSubData", 0)}),
        formula("picture.FragColor", sampled("image"), name="texels from a buffer"),
        exact("picture.FragColor", Output("picture, copied.FragColor"), name="same as from memory"),
        *sent(
            None,
            {
                "written": ("glMapBufferRange", 1, {"length": 4 * 480 * 320}),
                "then read": ("glTexImage2D", 1, {**IMAGE, "after": "glUnmapBuffer"}),
            },
        ),
        gl_call(*TO_WRITE, before=BOUND, name="map with a buffer bound"),
        gl_call(*RANGE, 168, f"{WRITE} | {GIVE_UP}", before=BOUND, name="given up and written"),
        *answers(
            {"size of the buffer": (SIZE, 168, BOUND), "unmap": (call(*UNMAP), "GL_TRUE", MAPPED)}
            | {"a buffer that is mapped": (IS_MAPPED, "GL_TRUE", (*BOUND, READ_WRITTEN))}
            | {
                f"mapped, {word}": (ACCESS, f"GL_{word}", (*BOUND, call(*MAP, f"GL_{word}")))
                for word in ("READ_ONLY", "WRITE_ONLY", "READ_WRITE")
            }
        ),
        *errors(
            {
                UNBOUND: (call(*TO_WRITE), REFUSED),
                "map what is mapped": (call(*TO_WRITE), REFUSED, MAPPED),
                "unmap what is not mapped": (call(*UNMAP), REFUSED, BOUND),
                "written to while it is mapped": (WRITTEN, REFUSED, MAPPED),
                "given up and read": (call(*RANGE, 168, f"{READ} | {GIVE_UP}"), REFUSED, BOUND),
                "past the end of the buffer": (call(*RANGE, 172, WRITE), "invalid_value", BOUND),
            }
        ),
        attribute_layout({"aPos": (0, 12), "aColor": (84, 12)}, name="positions, then colours"),
        *rosette_checks(),
    ],
    errata=[
        Erratum(
            section="10",
            says="glBindBuffer(GL_ARRAY_BUFFER, 0) is called before glMapBuffer",
            truth="what is mapped is what is bound: with 0 bound, the call raises 0x0502",
            proof=UNBOUND,
        )
    ],
)
