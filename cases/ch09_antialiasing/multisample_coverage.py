"""Multisampling: a pixel has several samples, and an edge covers some of them.

The rasteriser tests whether each sample, not the pixel's centre, lies in the triangle. The fragment
shader still runs once a pixel, and its colour goes to the samples that are covered. Resolving is
left to the driver, and takes their mean: with k of n samples covered, k/n of the colour. The driver
chooses where the samples lie; glGetMultisamplefv returns their positions, and so does gl_FragCoord
in a fragment shader that runs once for each sample.

Look at: an edge through twelve by eight pixels, the dark side on its right. Each pixel's four
samples are drawn where they are: orange if the triangle covers them, blue if not. A pixel's grey is
the share of orange ones: five levels are possible, and the edge runs through all of them.

Try: in `ch09_antialiasing/multisample_coverage.frag` write `texelFetch(samples, pixel, 0).r);` for
`coverage);`: one sample decides for the whole pixel, and no grey is left.
"""

import numpy as np

from shaderlab import (
    Case,
    Mesh,
    Output,
    State,
    Target,
    boundaries,
    formula,
    fullscreen,
    measure,
    mesh_pass,
)
from shaderlab.glslmath import distance, floor, fract, min, mix, swizzle, vec3, vec4, where
from shaderlab.glslmath.sampling import texelFetch
from shaderlab.reference.coverage import on_inner_side

from ..scenes.laws import pixel_place
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import rectangle

SIZE = (12, 8)
SAMPLES = ("each", "placesX", "placesY")
# The edge, from lower right to upper left: between whole pixels, and no sample lies on it.
FOOT, HEAD = (9.0, 0.0), (2.0, 8.0)
SHAPE, WHOLE = (
    Mesh(attributes={"aPos": np.array(corners)}, indices=np.array(indices))
    for corners, indices in (
        ([(0.0, 0.0), FOOT, HEAD, (0.0, 8.0)], [0, 1, 2, 0, 2, 3]),
        ([(0.0, 0.0), (24.0, 0.0), (0.0, 16.0)], [0, 1, 2]),
    )
)


def drawn(name, fragment, mesh, output, **state):
    """A shape in the multisampled target."""
    return mesh_pass(
        "ch09_antialiasing/shape.vert",
        f"ch09_antialiasing/{fragment}.frag",
        mesh,
        uniforms={"size": tuple(map(float, SIZE))},
        target=Target(size=SIZE, samples=4, colors=output),
        state=State(**state),
        name=name,
    )


def shown(name, size, **outputs):
    """Everything that is in the samples, read out, or some of it."""
    return fullscreen(
        "ch09_antialiasing/multisample_coverage.frag",
        name=name,
        domain={"at": rectangle((0.0, 0.0), tuple(map(float, SIZE)))},
        textures={
            "resolved": Output("edge.lit"),
            "samples": Output("edge.lit"),
            "places": Output("where.place"),
        },
        target=Target(size=size, colors=outputs),
    )


def inside(frag_coord, edge_sample_positions):
    """Whether each of a pixel's samples lies on the bright side."""
    corner = swizzle(frag_coord, "xy") - 0.5
    return [on_inner_side(corner + place, FOOT, HEAD) for place in edge_sample_positions]


def every_sample(frag_coord, edge_sample_positions):
    """The four samples."""
    return vec4(*inside(frag_coord, edge_sample_positions))


def share(frag_coord, edge_sample_positions):
    """k of n samples."""
    one, two, three, four = inside(frag_coord, edge_sample_positions)
    return (one + two + three + four) / 4.0


def places(axis):
    """The samples' places in a pixel, along one axis."""
    return lambda edge_sample_positions: vec4(*(swizzle(p, axis) for p in edge_sample_positions))


def drawing(at, resolved, samples, places):
    """Greys, a grid, and the samples in their places."""
    pixel, within = floor(at), fract(at)
    share = swizzle(texelFetch(resolved, pixel), "r")
    color = mix(vec3(0.10, 0.13, 0.20), vec3(0.93, 0.90, 0.80), share)
    x, y = swizzle(within, "x"), swizzle(within, "y")
    color = where(min(min(x, y), min(1.0 - x, 1.0 - y)) < 0.02, vec3(0.45), color)
    for k in range(4):
        lit = swizzle(texelFetch(samples, pixel, k), "r") > 0.5
        near = distance(within, swizzle(texelFetch(places, pixel, k), "xy")) < 0.07
        shown = where(lit, vec3(0.95, 0.55, 0.10), vec3(0.30, 0.55, 0.75))
        color = where(near, shown, color)
    return vec4(color, 1.0)


def levels(coverage):
    """How many different values there are."""
    return len(np.unique(coverage))


case = Case(
    title="Coverage of samples",
    section="9.1",
    math=r"c = \frac 1n \sum_{i=1}^{n} \left[\, p + s_i \in \text{triangle} \,\right]",
    passes=(
        *drawn("edge", "lit", SHAPE, {"lit": "r32f"}),
        *drawn("where", "sample_place", WHOLE, {"place": "rg32f"}, sample_shading=1.0),
        *shown("table", SIZE, coverage="r32f", **dict.fromkeys(SAMPLES, "rgba32f")),
        *shown("picture", (924, 616), FragColor="rgba32f"),
        *shown("small", (132, 88), FragColor="rgba32f"),
    ),
    picture="picture.FragColor",
    expect=[
        formula("table.coverage", share, name="resolved: k of n samples"),
        formula("table.each", every_sample, name="each sample"),
        formula("table.placesX", places("x"), name="where samples are, to the right"),
        formula("table.placesY", places("y"), name="where samples are, upward"),
        formula("edge.gl_Position", pixel_place),
        formula("where.gl_Position", pixel_place),
        formula("small.FragColor", drawing, name="the drawing"),
        boundaries("small.FragColor", drawing, name="the drawing's edges"),
        enlarged_check(),
        measure(
            "levels along the edge",
            levels,
            reads={"coverage": "table.coverage"},
            equals=5,
            digits=0,
            note="0, ¼, ½, ¾ and 1",
        ),
    ],
)
