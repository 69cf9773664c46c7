"""Usage hints: nine words that tell the driver what a buffer is for, without any obligation.

The first half says how often the contents change and are used: STREAM once and a few times, STATIC
once and many times, DYNAMIC again and again. The second half says who writes and who reads: DRAW
the program for OpenGL, READ OpenGL for the program, COPY OpenGL for itself. All nine draw the same
pixels, a STATIC buffer may be written to any number of times, and a READ one may be drawn from.

Look at: nine butterflies, one for each hint, out of buffers that were made empty. All are alike.
"""

from shaderlab import Case, Erratum, Output, attribute_layout, exact
from shaderlab.engine.expectations.gl_call import Object, call

from ..scenes.api import answers, sent
from ..scenes.draws import drawn
from ..scenes.figures import each_draw
from ..scenes.flat_figures import butterfly, pictured, pictured_checks
from ..scenes.panels import cell, picture
from ..scenes.rosette import LIGHT, encoded, rosette_checks

OFTEN = ("stream", "static", "dynamic")
WHO = ("draw", "read", "copy")
USAGES = tuple(f"{often}_{who}" for often in OFTEN for who in WHO)


def hinted(usage, place=None):
    """The butterfly, its buffer made with a hint and then written to."""
    mesh = butterfly(layout="batched", usage=usage, upload="sub_data")
    return drawn("ch10_buffers/rosette", mesh, cell=place)


def alone(usage):
    """A window with this one butterfly."""
    return picture([hinted(usage)], (128, 128), usage, clear=LIGHT)


def written(usage, times):
    """A buffer of four bytes, made with a hint and written to so many times."""
    target = "GL_ARRAY_BUFFER"
    return (
        call("glBindBuffer", target, Object("buffer")),
        call("glBufferData", target, 4, None, f"GL_{usage.upper()}"),
        *(call("glBufferSubData", target, 0, 4, bytes([k] * 4)) for k in range(1, times + 1)),
    )


def told(usage):
    """The hint reaches the driver once, with a buffer that is empty."""
    empty = {"usage": f"GL_{usage.upper()}", "data": "NULL", "size": 24 * butterfly().vertices}
    return sent(usage, {f"{usage.upper()} is what the driver is told": ("glBufferData", 1, empty)})


WRITTEN = {"stream": ("once", 1), "static": ("once", 1), "dynamic": ("thrice", 3)}
ALL = [hinted(usage, cell(place, 3, 3)) for place, usage in enumerate(USAGES)]
BATCHED = {"aPos": (0, 12), "aColor": (12 * butterfly().vertices, 12)}
LAYOUT = "what the vertex array holds: bytes to begin at, and strides"

case = Case(
    title="Usage hints",
    section="10",
    math=r"\{\mathtt{STREAM}, \mathtt{STATIC}, \mathtt{DYNAMIC}\} \times "
    r"\{\mathtt{DRAW}, \mathtt{READ}, \mathtt{COPY}\}, \qquad 3 \cdot 3 = 9",
    passes=(*pictured(ALL, (576, 576), LIGHT), *(alone(usage) for usage in USAGES)),
    picture="picture.FragColor",
    columns=[name.upper() for name in WHO],
    rows=[name.upper() for name in reversed(OFTEN)],
    expect=[
        *rosette_checks("stream_draw"),
        *pictured_checks(),
        *each_draw("judged.FragColor", encoded, {k: f"picture, {u}" for k, u in enumerate(USAGES)}),
        attribute_layout(BATCHED, pass_name="static_draw", name=LAYOUT),
        *(check for usage in USAGES for check in told(usage)),
        *answers(
            {
                f"{usage.upper()}: written {so_often}, the last write is what is there": (
                    call("glGetBufferSubData", "GL_ARRAY_BUFFER", 0, 4),
                    (times,) * 4,
                    written(usage, times),
                )
                for usage in USAGES
                for so_often, times in [WRITTEN[usage.partition("_")[0]]]
            }
        ),
        *(
            exact(f"{usage}.FragColor", Output("stream_draw.FragColor"), name=usage.upper())
            for usage in USAGES[1:]
        ),
    ],
    errata=[
        Erratum(
            section="10",
            says="data in a GL_STATIC_DRAW buffer does not change",
            truth="it is a hint: the buffer was made empty, and glBufferSubData wrote to it since",
            proof="STATIC_DRAW",
        ),
        Erratum(
            section="10",
            says="the hints of READ and COPY are for PBOs and FBOs only",
            truth="any buffer takes all nine: this one holds vertices, and is drawn from",
            proof="STATIC_READ",
        ),
        Erratum(
            section="10",
            says="a VBO lies in main memory, a VAO on the graphics card",
            truth="where a buffer lies is the driver's choice, which these hints may guide; a "
            "VAO holds no vertices, it says from which buffer and byte each attribute is read",
            proof=LAYOUT,
        ),
    ],
)
