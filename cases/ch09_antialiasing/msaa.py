"""Antialiasing by multisampling: how far an edge is from the true one.

The right value of a pixel on an edge is the area of it that is covered. One sample a pixel says 0
or 1, four say a quarter more or less. The mean error along edges of every direction falls from
about one quarter to less than a tenth; a drawing is smoother than its resolution allows, at the
cost of four times the memory for colour and depth. The driver chooses the number of samples: at
least as many as requested, and every driver supports four.

Look at: the same wheel of spokes, on the left with one sample a pixel, on the right with four, both
enlarged eightfold. Spokes that are nearly upright or level show it best: steps become ramps. Near
the hub, where spokes are thinner than a pixel, one sample loses them altogether.

Try: in `ch09_antialiasing/msaa.frag` write `float shown = lit` for `float shown = pow(max(lit,
1.0e-6), 1.0 / 2.2)`: the smooth edges get darker, because a display expects encoded light.
"""

from functools import cache
from math import cos, pi, sin

import numpy as np

from shaderlab import (
    Case,
    Mesh,
    Output,
    Target,
    formula,
    fullscreen,
    gl_call,
    gl_calls,
    measure,
    mesh_pass,
    reading,
)
from shaderlab.engine.expectations.gl_call import Location, Object, Program, call
from shaderlab.reference.coverage import area_coverage

from ..scenes.laws import pixel_place
from ..scenes.panels import rectangle

SIZE = (64, 64)
SPOKES = 13


def spoke(k):
    """A thin triangle from the hub to the rim, its corners on sixteenths of a pixel."""
    corners = [(32.0, 32.0)]
    for edge in (-0.35, 0.35):
        turn = 2.0 * pi * (k + edge) / SPOKES + 0.1
        corners.append((32.0 + 29.0 * cos(turn), 32.0 + 29.0 * sin(turn)))
    return [tuple(round(16.0 * v) / 16.0 for v in corner) for corner in corners]


SHAPES = [spoke(k) for k in range(SPOKES)]
WHEEL = Mesh(attributes={"aPos": np.array(SHAPES).reshape(-1, 2)}, indices=np.arange(3 * SPOKES))


def drawn(name, samples):
    """The wheel with so many samples a pixel."""
    return mesh_pass(
        "ch09_antialiasing/shape.vert",
        "ch09_antialiasing/lit.frag",
        WHEEL,
        uniforms={"size": tuple(map(float, SIZE))},
        target=Target(size=SIZE, samples=samples, colors={"lit": "r32f"}),
        name=name,
    )


SWITCH = {
    word: (call(f"gl{c}able", "GL_MULTISAMPLE"),) for word, c in (("on", "En"), ("off", "Dis"))
}
FRAMES = {"drawn": 4, "resolved": 0}


def point_at_the_edge(program):
    """Calls that make a framebuffer of one pixel and four samples, and one to resolve it to. The
    program's point, a pixel wide, covers the samples from 0.3 to the right."""
    for name, samples in FRAMES.items():
        buffer = ("GL_RENDERBUFFER", Object("renderbuffer", name))
        yield call("glBindFramebuffer", "GL_FRAMEBUFFER", Object("framebuffer", name))
        yield call("glBindRenderbuffer", *buffer)
        yield call("glRenderbufferStorageMultisample", buffer[0], samples, "GL_RGBA8", 1, 1)
        yield call("glFramebufferRenderbuffer", "GL_FRAMEBUFFER", "GL_COLOR_ATTACHMENT0", *buffer)
    yield call("glBindFramebuffer", "GL_FRAMEBUFFER", Object("framebuffer", "drawn"))
    yield call("glViewport", 0, 0, 1, 1)
    yield call("glUniform2f", Location("size", program), 1.0, 1.0)
    yield call("glBindVertexArray", Object("vertex_array"))
    yield call("glVertexAttrib2f", 0, 0.8, 0.5)


RESOLVED = (
    call("glDrawArrays", "GL_POINTS", 0, 1),
    call("glBindFramebuffer", "GL_READ_FRAMEBUFFER", Object("framebuffer", "drawn")),
    call("glBindFramebuffer", "GL_DRAW_FRAMEBUFFER", Object("framebuffer", "resolved")),
    call("glBlitFramebuffer", *(0, 0, 1, 1) * 2, "GL_COLOR_BUFFER_BIT", "GL_NEAREST"),
    call("glBindFramebuffer", "GL_READ_FRAMEBUFFER", Object("framebuffer", "resolved")),
)


@cache
def true_area():
    """The covered area of each pixel."""
    return area_coverage(SHAPES, SIZE)


def errors(lit, on_edges):
    """How far pixels are from the area that is covered: those on an edge, or all others."""
    right = true_area()
    edge = (right > 1.0e-9) & (right < 1.0 - 1.0e-9)
    return np.abs(lit[..., 0] - right)[edge == on_edges]


def edge_error(lit):
    """The mean error of the pixels that an edge crosses."""
    return errors(lit, True).mean()


def inner_error(lit):
    """The largest error of those that are covered as a whole, or not at all."""
    return errors(lit, False).max()


def covered_area(lit):
    """All light together, over the wheel's area."""
    return lit.sum() / true_area().sum()


def furthest_shown(one, four, FragColor):
    """How far the picture is, at most, from both wheels enlarged eightfold, their light encoded."""
    lit = np.concatenate([one, four], axis=1).repeat(8, axis=0).repeat(8, axis=1)
    dark, light = np.array([0.11, 0.14, 0.22]), np.array([0.96, 0.93, 0.84])
    shown = dark + (light - dark) * np.maximum(lit, 1e-6) ** (1.0 / 2.2)
    shown[:, 510:514] = 0.95, 0.55, 0.10
    return np.abs(FragColor - np.dstack([shown, np.ones_like(lit)])).max()


LIT = {1: "one.lit", 4: "four.lit"}
BOTH = [
    reading(f"{n} a pixel", reads={"lit": f"{name}.lit"}) for n, name in ((1, "one"), (4, "four"))
]

case = Case(
    title="Multisample antialiasing",
    section="9.2",
    math=r"\left| \frac kn - \text{area} \right|, \qquad \text{area} = "
    r"\int_{\text{pixel}} [\, p \in \text{shape} \,]\, dp",
    passes=(
        *drawn("one", 0),
        *drawn("two", 2),
        *drawn("four", 4),
        *fullscreen(
            "ch09_antialiasing/msaa.frag",
            name="picture",
            domain={"at": rectangle((0.0, 0.0), (2.0, 1.0))},
            textures={"one": Output("one.lit"), "four": Output("four.lit")},
            target=Target(size=(1024, 512)),
        ),
    ),
    expect=[
        formula("one.gl_Position", pixel_place),
        measure(
            "mean error of an edge's pixels",
            edge_error,
            readings=[
                # One straight edge in a pixel cuts off an area a that may be anything, evenly. One
                # sample in the middle is off by min(a, 1 − a): by ¼ on average. Of four, at best
                # the nearest quarter is found: 1/16 on average, and nearly twice that for edges
                # that meet two samples at once. Pixels with two edges add a fifth either way.
                reading(1, reads={"lit": LIT[1]}, between=(0.2, 0.3)),
                reading(4, reads={"lit": LIT[4]}, between=(0.05, 0.11)),
            ],
            x_label="samples",
            y_label="mean |k/n − area| along the edges",
        ),
        measure(
            "two samples: the mean error of an edge's pixels",
            edge_error,
            reads={"lit": "two.lit"},
            # At best ⅛; a driver without two samples a pixel takes more.
            between=(0.05, 0.18),
        ),
        formula("two.gl_Position", pixel_place, name="the corners, two samples"),
        formula("four.gl_Position", pixel_place, name="the corners, four samples"),
        *(
            gl_call(
                "glGetRenderbufferParameteriv",
                "GL_RENDERBUFFER",
                "GL_RENDERBUFFER_SAMPLES",
                before=(
                    call("glBindRenderbuffer", "GL_RENDERBUFFER", Object("renderbuffer")),
                    call(
                        "glRenderbufferStorageMultisample",
                        *("GL_RENDERBUFFER", asked, "GL_RGBA8", 64, 64),
                    ),
                ),
                at_least=asked,
                name=f"{asked} samples are asked for: so many, or more",
            )
            for asked in (1, 2, 3, 4)
        ),
        *(
            gl_call(
                "glReadPixels",
                *(0, 0, 1, 1, "GL_RED", "GL_UNSIGNED_BYTE"),
                before=(*point_at_the_edge(Program("four")), *SWITCH[switch], *RESOLVED),
                returns=level,
                name=f"GL_MULTISAMPLE {switch}: a point over {share}",
            )
            for switch, level, share in (("off", 255, "a pixel or none"), ("on", 191, "¾ of one"))
        ),
        gl_call(
            "glRenderbufferStorageMultisample",
            *("GL_RENDERBUFFER", 1 << 16, "GL_RGBA8", 64, 64),
            before=(call("glBindRenderbuffer", "GL_RENDERBUFFER", Object("renderbuffer")),),
            raises="invalid_operation",
            name="more samples than there are: 0x0502",
        ),
        gl_call("glGetIntegerv", "GL_MAX_SAMPLES", at_least=4, name="every driver offers four"),
        # A driver may give more than it is asked for, so pixels can't tell.
        gl_calls(
            "glTexImage2DMultisample", samples=4, times=1, pass_name="four", name="four asked"
        ),
        measure(
            "the picture",
            furthest_shown,
            reads={"one": LIT[1], "four": LIT[4], "FragColor": "picture.FragColor"},
            at_most=2.0**-20,
            note="pow may err by 6 ULP of a number below 1, and mix rounds three times",
        ),
        measure("largest error away from edges", inner_error, readings=BOTH, equals=0.0, digits=9),
        measure("covered, over the area", covered_area, readings=BOTH, between=(0.98, 1.02)),
    ],
)
