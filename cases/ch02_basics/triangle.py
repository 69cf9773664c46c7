"""Three vertices in a buffer: the smallest thing that the pipeline draws.

The vertex shader passes each corner on unchanged, so the corners are device coordinates: −1…1
across the window and −1…1 up it, whatever its size in pixels. Rasterisation then tests whether each
pixel's centre lies inside, and runs the fragment shader where it does. Half the width times the
height gives an area of ½ of the window's 4, one eighth: 64800 of 720 × 720 pixels, exactly, because
a centre on an edge belongs to one side only.

Look at: the paper, whose lines are a quarter apart. The corners lie on its crossings, two lines
left and right of the middle, two below it and two above.

Try: in `ch02_basics/triangle.vert` write `aPos.z, 2.0` for `aPos.z, 1.0`: each corner is divided by
2, and a quarter of the pixels is left.
"""

import numpy as np

from shaderlab import Case, Mesh, boundaries, coverage, formula
from shaderlab.engine.expectations.gl_call import call
from shaderlab.glslmath import abs, fract, min, swizzle, vec3, vec4, where
from shaderlab.reference.transforms import signed_area

from ..scenes.api import answers
from ..scenes.draws import drawn
from ..scenes.figures import figure, results
from ..scenes.laws import device_place
from ..scenes.objects import buffers_bound
from ..scenes.panels import panel, picture, square

CORNERS = np.array([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.0, 0.5, 0.0)])
WINDOW = (720, 720)
PAPER = panel("ch02_basics/graph_paper.frag", {"place": square()})


def triangle(fragment):
    """The triangle, with one fragment shader or the other."""
    shaders = ("ch02_basics/triangle.vert", f"ch02_basics/{fragment}.frag")
    return drawn(shaders, Mesh(attributes={"aPos": CORNERS}))


def orange():
    """One colour everywhere."""
    return vec4(1.0, 0.5, 0.2, 1.0)


def on_a_line(place, width):
    """Whether a place is this near to one of the paper's lines, a quarter apart."""
    off = abs(fract(4.0 * place + 0.5) - 0.5) / 4.0
    return min(swizzle(off, "x"), swizzle(off, "y")) < width


def paper(place):
    """Lines a quarter apart, the two axes brighter."""
    color = where(on_a_line(place, 0.0028), vec3(0.20, 0.27, 0.36), vec3(0.10, 0.14, 0.20))
    axis = min(abs(swizzle(place, "x")), abs(swizzle(place, "y"))) < 0.0056
    return vec4(where(axis, vec3(0.62, 0.70, 0.78), color), 1.0)


def orange_on_paper(place):
    """Orange, through which the lines are seen."""
    return vec4(vec3(1.0, 0.5, 0.2) * where(on_a_line(place, 0.0028), 0.85, 1.0), 1.0)


def flat(aPos):
    """Where on the paper the corner is."""
    return swizzle(aPos, "xy")


# One buffer for each target, each of another size, all of them bound at the same time.
TARGETS = {"GL_ARRAY_BUFFER": 5, "GL_UNIFORM_BUFFER": 6, "GL_COPY_READ_BUFFER": 7}


def own_size(target, size):
    """The size of the buffer that is bound there, and what it must be."""
    size_of = call("glGetBufferParameteriv", target, "GL_BUFFER_SIZE")
    return size_of, size, buffers_bound(TARGETS)


AREA = signed_area(CORNERS)
PLACE = (0.25, -0.75, 0.5)

case = Case(
    title="A triangle",
    section="2.2.2",
    math=r"\text{pixels} = \tfrac12 \cdot 1 \cdot 1 \cdot \frac{720^2}{2 \cdot 2} = 64800",
    passes=(
        picture([PAPER, triangle("triangle_picture")], WINDOW),
        picture([triangle("triangle")], WINDOW, "main"),
    ),
    picture="picture.FragColor",
    expect=[
        formula("picture.FragColor", paper, draw=0, name="the paper"),
        formula("picture.FragColor", orange_on_paper, name="the triangle on it"),
        boundaries("picture.FragColor", paper, draw=0, name="the paper's lines"),
        boundaries("picture.FragColor", orange_on_paper, name="lines under the triangle"),
        coverage(64800, name="pixels covered"),
        formula("gl_Position", device_place),
        formula("picture.gl_Position", device_place, name="corners on the paper"),
        formula("picture.place", flat, name="where on the paper they are"),
        formula("place", flat),
        formula("FragColor", orange),
        figure("gl_Position", "a corner somewhere", {"aPos": PLACE}, (*PLACE, 1.0)),
        *answers({f"{word} has its own buffer": own_size(word, n) for word, n in TARGETS.items()}),
        *results({"signed area": (AREA, 0.5, "positive: counter-clockwise")}),
        *results({"share of the window": (AREA / 4.0, 0.125, "64800 of 518400 pixels")}, digits=4),
    ],
)
