"""Batched attributes: 111222333 holds what 123123123 holds, and draws the same bits.

A buffer may keep whole vertices together (interleaved, 123123123) or all of one attribute before
all of the next (batched, 111222333). The first is kinder to caches when each vertex is read whole.
The second suits data that comes in arrays, as from many model files, and data of which one
attribute changes each frame: it takes one glBufferSubData. Only stride and offsets tell OpenGL
which one it is: 24 bytes and 0, 12 for seven interleaved vertices, 12 bytes and 0, 84 for the same
ones batched.

Look at: the rosette, and below it the 42 numbers that it is read from, in the order of memory:
places in greys, colours in red, green and blue. The order differs each time, and the rosettes do
not in a single bit.
"""

from shaderlab import Case, Output, attribute_layout, exact, query

from ..scenes.draws import drawn
from ..scenes.figures import each_draw, results
from ..scenes.flat_figures import memory_map, pictured, pictured_checks
from ..scenes.laws import device_place
from ..scenes.panels import cell
from ..scenes.rosette import LIGHT, encoded, rosette, rosette_checks, window

UPLOADS = {"separate": "data", "interleaved": "data", "batched": "sub_data"}
MESHES = [rosette(layout=layout, upload=upload) for layout, upload in UPLOADS.items()]
SHOWN = (*MESHES, *map(memory_map, MESHES))
ALL = [
    drawn("ch10_buffers/rosette", mesh, cell=cell(k, 3, 2, from_above=True))
    for k, mesh in enumerate(SHOWN)
]
NAMES = dict(enumerate((*UPLOADS, *(f"memory, {layout}" for layout in UPLOADS))))


def size_of(layout):
    """Bytes in all of a rosette's vertex buffers."""
    return sum(len(piece) for parts in rosette(layout=layout).parts() for _, piece in parts)


case = Case(
    title="Batched attributes",
    section="8.3",
    math=r"\text{interleaved: } s_i = \textstyle\sum_k b_k,\ o_i = \sum_{k<i} b_k \qquad "
    r"\text{batched: } s_i = b_i,\ o_i = n \sum_{k<i} b_k",
    passes=(
        *pictured(ALL, (960, 640), LIGHT),
        *(
            window(layout, clear=LIGHT, layout=layout, upload=upload)
            for layout, upload in UPLOADS.items()
        ),
    ),
    picture="picture.FragColor",
    columns=("111 and 222", "123123123", "111222333"),
    rows=("drawn", "in memory"),
    expect=[
        *pictured_checks(),
        *each_draw("judged.FragColor", encoded, NAMES, "{}, in the picture"),
        *each_draw("judged.gl_Position", device_place, NAMES, "{}: places"),
        exact("batched.FragColor", Output("interleaved.FragColor"), name="111222 equals 123123"),
        exact("batched.FragColor", Output("separate.FragColor"), name="… and two buffers"),
        attribute_layout({"aPos": (0, 12), "aColor": (84, 12)}, name="batched: 111222"),
        attribute_layout(
            {"aPos": (0, 24), "aColor": (12, 24)},
            pass_name="interleaved",
            name="interleaved: 123123",
        ),
        attribute_layout(
            {"aPos": (0, 12), "aColor": (0, 12)}, pass_name="separate", name="separate: 111, 222"
        ),
        *results({f"bytes, {layout}": (size_of(layout), 168.0) for layout in UPLOADS}, digits=0),
        query("vertices_submitted", equals=18, name="vertices submitted"),
        *rosette_checks(),
    ],
)
