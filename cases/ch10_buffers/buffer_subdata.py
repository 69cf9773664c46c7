"""glBufferSubData: a buffer made without contents, then filled piece by piece.

glBufferData with a null pointer only reserves: here 168 bytes. Two calls of glBufferSubData then
write the positions, seven times three floats, to byte 0, and the colours, another 84 bytes, to byte
84. So all of one attribute stands before all of the next (111222333): the stride is the size of one
of them, 12 bytes, and the colours' pointer begins at byte 84.

Buffers are not for vertices alone. While one is bound as GL_PIXEL_PACK_BUFFER, glReadPixels writes
into it, and while one is bound as GL_PIXEL_UNPACK_BUFFER, a texture's image is read from it: the
pointer is then a number of bytes into the buffer.

Look at: the buffer's 42 numbers, after the first piece, and after the second; then what is drawn.
Were the colours' pointer left at byte 0, positions would be used as colours: none has any blue.

Try: in `ch10_buffers/rosette.vert` write `ourColor = abs(aPos)` for `ourColor = aColor`: positions
are shown as colours, without their signs, as when the colours' pointer begins at byte 0.
"""

from dataclasses import replace

from shaderlab import Case, Erratum, Output, attribute_layout, exact, gl_call, measure
from shaderlab.engine.expectations.gl_call import Object, call

from ..scenes.api import ONE_PIXEL, answers, sent
from ..scenes.draws import drawn
from ..scenes.figures import each_draw
from ..scenes.flat_figures import memory_map, squares_check
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged
from ..scenes.rosette import LIGHT, encoded, rosette, rosette_checks, window

PIXELS, TEXEL = Object("buffer"), bytes(range(10, 90, 10))
READ_BACK = (
    *ONE_PIXEL,
    call("glClearColor", 0.2, 0.4, 0.6, 1.0),
    call("glClear", "GL_COLOR_BUFFER_BIT"),
    call("glBindBuffer", "GL_PIXEL_PACK_BUFFER", PIXELS),
    call("glBufferData", "GL_PIXEL_PACK_BUFFER", 4, None, "GL_STREAM_READ"),
    call("glReadPixels", 0, 0, 1, 1, "GL_RGBA", "GL_UNSIGNED_BYTE", 0),
)
TEXTURE = (0, "GL_RGBA8", 1, 1, 0, "GL_RGBA", "GL_UNSIGNED_BYTE", 4)  # from byte 4 of the buffer
UNPACKED = (
    call("glBindBuffer", "GL_PIXEL_UNPACK_BUFFER", PIXELS),
    call("glBufferData", "GL_PIXEL_UNPACK_BUFFER", 8, TEXEL, "GL_STREAM_DRAW"),
    call("glBindTexture", "GL_TEXTURE_2D", Object("texture")),
    call("glTexImage2D", "GL_TEXTURE_2D", *TEXTURE),
)
FOUR_BYTES = call("glGetBufferSubData", "GL_PIXEL_PACK_BUFFER", 0, 4)
IMAGE = call("glGetTexImage", "GL_TEXTURE_2D", 0, "GL_RGBA", "GL_UNSIGNED_BYTE")
STATIC = {"usage": "GL_STATIC_DRAW"}
TARGETS = {"PIXEL_PACK": "a buffer that pixels are read into", "UNIFORM": "a buffer of uniforms"}
TWO = memory_map(rosette(layout="batched"), 7, 34)
ONE = replace(TWO, indices=TWO.indices[:126])  # 21 squares of two triangles
FIGURES = enumerate((ONE, TWO, rosette()))
SHOWN = [drawn("ch10_buffers/rosette", mesh, cell=cell(k, 3)) for k, mesh in FIGURES]

case = Case(
    title="Filling a buffer in pieces",
    section="10",
    math=r"84 = 7 \cdot 3 \cdot 4\ \text{bytes}, \qquad \text{positions}: 0 \ldots 83, \quad "
    r"\text{colours}: 84 \ldots 167",
    passes=(
        *enlarged(SHOWN, (192, 64), 5, clear=LIGHT),
        window("at once", side=257, layout="separate", upload="data"),
        window("main", side=257, layout="batched", upload="sub_data"),
    ),
    picture="picture.FragColor",
    columns=("after the first piece", "after the second", "drawn"),
    expect=[
        enlarged_check(),
        squares_check(128),
        *each_draw("small.FragColor", encoded, enumerate(("one piece", "two pieces", "drawn"))),
        attribute_layout(
            {"aPos": (0, 12), "aColor": (84, 12)}, name="positions at 0, colours at 84"
        ),
        exact("FragColor", Output("at once.FragColor"), name="same as two buffers"),
        *sent(
            "main",
            {
                "two pieces": ("glBufferSubData", 2, {"size": 84}),
                "the second one at byte 84": ("glBufferSubData", 1, {"offset": 84}),
                "reserved only": ("glBufferData", 1, {"size": 168, "data": "NULL", **STATIC}),
                "indices, at once": ("glBufferData", 1, {"size": 72, **STATIC}),
                "and nothing else": ("glBufferData", 2),
            },
        ),
        *rosette_checks(),
        *(
            gl_call("glBindBuffer", f"GL_{target}_BUFFER", Object("buffer"), name=name)
            for target, name in TARGETS.items()
        ),
        *answers(
            {
                "pixels are read into a buffer": (FOUR_BYTES, (51, 102, 153, 255), READ_BACK),
                "a texture is filled from byte 4 of a buffer": (IMAGE, tuple(TEXEL[4:]), UNPACKED),
            }
        ),
        measure(
            "its middle is white", lambda FragColor: FragColor[128, 128].min(), equals=1.0, digits=5
        ),
    ],
    errata=[
        Erratum(
            section="10",
            says="glBindBuffer and glBufferData have only two targets, arrays and their indices",
            truth="there are more, for pixels and uniforms among others",
            proof="a buffer that pixels are read into",
        )
    ],
)
