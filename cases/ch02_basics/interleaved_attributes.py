"""Three attributes in one buffer: the stride steps from vertex to vertex, the offset into one.

A vertex is a position, a colour and a place in a texture: 3 + 3 + 2 floats, 32 bytes. Vertices
follow each other in one buffer as 123123123: every attribute repeats after a *stride* of 32 bytes,
and within a vertex the position begins at byte 0, the colour at 12, the texture coordinates at 24.
Numbers may also be bytes, which become fractions of 255 if they are normalised; and an attribute
that is not enabled has one value for all vertices. OpenGL neither copies nor sorts, it reads at
offset + stride · n. Each of the three corners has one whole primary colour, so the colour of a
pixel is its three barycentric coordinates.

Look at: the corners, pure red, green and blue, and the fields, which are an eighth of the texture's
coordinates wide and high. Both grow evenly over the triangle: they are interpolated alike. Beside
it lies the buffer, a row for each vertex: three greys for the place, red, green and blue for the
colour, two greys for the texture; brighter is more.

Try: in `ch02_basics/interleaved_attributes.frag` write `step(0.5, ourColor)` for `shade *
ourColor`: a colour is left where its corner has more than half of the pixel, and the middle is
black.
"""

import numpy as np

from shaderlab import Case, Output, attribute_layout, boundaries, coverage, exact, formula, measure
from shaderlab.engine.expectations.gl_call import Object, call
from shaderlab.glslmath import floor, mod, swizzle, vec4, where
from shaderlab.reference.rasterisation import barycentric

from ..scenes.api import answers, pixel
from ..scenes.draws import drawn
from ..scenes.figures import figures
from ..scenes.flat_figures import memory_map, pictured, pictured_checks
from ..scenes.laws import device_place, unchanged
from ..scenes.panels import cell, centres, picture
from ..scenes.rosette import LIGHT, encoded

CORNERS = np.array([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.0, 0.5, 0.0)])
PLACES = np.array([(0.0, 0.0), (1.0, 0.0), (0.5, 1.0)])
VERTICES = {"aPos": CORNERS, "aColor": np.eye(3), "aTexCoord": PLACES}
LAYOUT = {"aPos": (0, 32), "aColor": (12, 32), "aTexCoord": (24, 32)}
DARK = {"ourColor": (0.5, 0.25, 1.0), "TexCoord": (0.2, 0.1)}
FIELDS = {
    "a dark field": (DARK, (0.375, 0.1875, 0.75, 1.0)),
    "where a field begins": ({"TexCoord": (0.5, 0.3)}, (0.5, 0.25, 1.0, 1.0)),
    "a hundred fields further": ({"TexCoord": (6.3, 6.3)}, (0.5, 0.25, 1.0, 1.0)),
}
SIDE, SHADERS = 720, "ch02_basics/interleaved_attributes"


def triangle(layout, name):
    """The triangle, its attributes in memory one way or another."""
    mesh = {"attributes": VERTICES, "layout": layout}
    return picture([drawn(SHADERS, mesh)], (SIDE, SIDE), name, clear=LIGHT)


# The triangle, nearly twice as large, and beside it the 24 numbers that it is read from.
MESH = {"attributes": {**VERTICES, "aPos": 1.8 * CORNERS}, "layout": "interleaved"}
LARGE = drawn(SHADERS, MESH, cell=cell(0, 2))
NUMBERS = drawn("ch10_buffers/rosette", memory_map(LARGE.mesh, 8, top=20), cell=cell(1, 2))


def fields(ourColor, TexCoord):
    """The colour, by turns as it is and by a quarter darker."""
    field = floor(8.0 * TexCoord)
    even = mod(swizzle(field, "x") + swizzle(field, "y") + 0.5, 2.0) < 1.0
    return vec4(where(even, 1.0, 0.75) * ourColor, 1.0)


def off_by(share):
    """Largest distance of a pixel's three shares from its barycentric coordinates."""
    expected = barycentric(centres(SIDE), CORNERS[:, :2])
    inside = (expected > 1e-9).all(axis=-1)
    return np.abs(share - expected)[inside].max()


def bytes_as(normalized):
    """The colour from three bytes, the position as it is at first."""
    return (
        call("glBindBuffer", "GL_ARRAY_BUFFER", Object("buffer")),
        call("glBufferData", "GL_ARRAY_BUFFER", 4, bytes((64, 255, 0, 0)), "GL_STATIC_DRAW"),
        call("glVertexAttribPointer", 1, 3, "GL_UNSIGNED_BYTE", normalized, 0, 0),
        call("glEnableVertexAttribArray", 1),
    )


ONE_COLOR = (call("glVertexAttrib3f", 1, 0.2, 0.4, 0.6),)
NOT_ENABLED = "an attribute that is not enabled is the same for all vertices"
ANSWERS = {
    "bytes that are normalised: 0…255 is 0…1": pixel((64, 255, 0), bytes_as("GL_TRUE")),
    "bytes that are not: 64 is 64": pixel((255, 255, 0), bytes_as("GL_FALSE")),
    NOT_ENABLED: pixel((51, 102, 153), ONE_COLOR),
    "and (0, 0, 0) at first": pixel((0, 0, 0)),
}

case = Case(
    title="Attributes in one buffer",
    section="2.2.2",
    math=r"\text{address}(n) = \text{offset} + n \cdot \text{stride} = \text{offset} + 32\,n",
    passes=(
        *pictured((LARGE, NUMBERS), (720, 360), LIGHT),
        triangle("separate", "separate"),
        triangle("interleaved", "main"),
    ),
    picture="picture.FragColor",
    columns=("drawn", "in memory"),
    expect=[
        *pictured_checks(),
        formula("judged.FragColor", fields, draw=0, name="the triangle in the picture"),
        formula("judged.share", unchanged("ourColor"), draw=0, name="shares in the picture"),
        formula("judged.FragColor", encoded, draw=1, name="its numbers in memory"),
        formula("judged.gl_Position", device_place, draw=1, name="where each of them stands"),
        formula("judged.ourColor", unchanged("aColor"), draw=1, name="how bright it is"),
        attribute_layout(LAYOUT, name="stride 32, offsets 0, 12, 24"),
        *answers(ANSWERS),
        formula("gl_Position", device_place),
        formula("ourColor", unchanged("aColor")),
        formula("TexCoord", unchanged("aTexCoord")),
        formula("FragColor", fields),
        boundaries("FragColor", fields),
        formula("share", unchanged("ourColor")),
        measure(
            "distance from the barycentric coordinates",
            off_by,
            at_most=1e-5,
            note="interpolation is the driver's: OpenGL gives no bound, 24-bit floats leave 1e-7",
        ),
        exact("FragColor", Output("separate.FragColor"), name="same as three buffers"),
        exact("share", Output("separate.share"), name="shares of corners, too", pictured=False),
        coverage(64800, name="pixels covered"),
        *figures("FragColor", FIELDS, at=DARK, reference=fields),
    ],
)
