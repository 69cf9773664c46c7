"""What the depth buffer holds: not the distance z but F = (1/z − 1/n) / (1/f − 1/n).

The perspective division makes window depth even in 1/z, so that most of its codes lie close to the
near plane. A buffer of b bits distinguishes two surfaces at a distance z if they are z²·(1/n − 1/f)
/ 2^b apart: far away, that grows with the square of the distance, and the only help is a near plane
that is farther away. Ten times farther, and every step is ten times finer.

Look at: two charts over the distance from 0.1 to 100, in decades, with lines at 1 and 10: F with
the near plane at 1 above, at 0.1 below, and the far plane at 100. Each stripe is a twentieth of all
codes. With n = 0.1 half of them are used up before z = 0.2. The steps in the curve were counted in
the buffer itself: strips of it that run from 2 % before a distance to 2 % behind it.

Try: in `ch06_tests/depth_ruler.frag` write `(z - near) / (far - near)` for `(1.0 / z - 1.0 / near)
/ (1.0 / far - 1.0 / near)`: a depth that grows with the distance itself would give nearly all codes
to what is far.
"""

import numpy as np

from shaderlab import Case, Depth, Erratum, across, assets, formula, measure, reading, up
from shaderlab.engine.expectations.gl_call import call
from shaderlab.glslmath import abs, floor, min, mix, mod, mul, pow, swizzle, vec3, vec4, where
from shaderlab.reference.depth import depth_step, window_depth
from shaderlab.reference.transforms import perspective

from ..scenes.api import answers
from ..scenes.draws import tested
from ..scenes.figures import each_draw, figure, figures, results
from ..scenes.objects import depth_alone
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, picture

FAR = 100.0
NEARS = {"n = 0.1": 0.1, "n = 1": 1.0}
PLACES = (2.0, 5.0, 10.0, 20.0, 50.0, 90.0)
AROUND = 0.02  # of the distance, to either side
WIDTH = 512
SQUARE = assets.quad(2.0)
# No pixel of the judged chart lies on these.
LINES = {"the line at z = 1": 0.0, "the line at z = 10": 1.0, "just inside a line": 0.00398}
BESIDE = {"decade": 0.00402, "height": 0.5}


def chart(row, near):
    """F over the distance in one half of the picture."""
    domain = {"decade": across(-1.0, 2.0), "height": up(0.0, 1.0)}
    uniforms = {"near": near, "far": FAR}
    return panel("ch06_tests/depth_ruler.frag", domain, uniforms, cell=cell(row, 1, 2))


def strip(row, near):
    """A strip of the depth buffer around one distance."""
    planes = {"projection": perspective(1.0, 1.0, near, FAR), "near": near, "far": FAR}
    uniforms = {**planes, "middle": PLACES[row], "slope": AROUND * PLACES[row]}
    place = cell(row, 1, len(PLACES))
    state = {"depth": Depth(func="always"), "only": ("aPos",)}
    return tested("ch06_tests/depth_strip", SQUARE, uniforms, cell=place, **state)


def strips(name, near, depth="depth24"):
    """The depth buffer around all places."""
    draws = (strip(row, near) for row in range(len(PLACES)))
    return picture(draws, (WIDTH, 2 * len(PLACES)), name, depth=depth)


def charted(decade, near, far):
    """F of ten to the power of the decade."""
    return window_depth(pow(10.0, decade), near, far)


def painted(decade, height, near, far):
    """The chart's colours."""
    depth = charted(decade, near, far)
    share = mod(floor(20.0 * depth) + 0.5, 2.0) - 0.5
    below = mix(vec3(0.93, 0.62, 0.16), vec3(0.50, 0.27, 0.07), share)
    color = where(height < depth, below, vec3(0.10, 0.13, 0.20))
    line = min(abs(decade), abs(decade - 1.0))
    color = where(line < 0.004, vec3(0.75, 0.75, 0.75), color)
    return vec4(where(height > 0.985, vec3(0.97, 0.97, 0.97), color), 1.0)


def of_distance(Distance, near, far):
    """F of a strip's distance."""
    return window_depth(Distance, near, far)


def distance(aPos, middle, slope):
    """Even across the strip."""
    return middle + slope * aPos[..., 0:1]


def on_the_screen(aPos, projection, middle, slope):
    """A corner in clip space: where it is on the screen has nothing to do with its distance."""
    away = distance(aPos, middle, slope)
    depth = swizzle(mul(projection, vec4(0.0, 0.0, -away, 1.0)), "zw")
    return vec4(swizzle(aPos, "xy") * swizzle(depth, "y"), depth)


def counted_step(depth, row):
    """How far a step of the buffer reaches: the strip's length over the codes that it takes."""
    codes = np.round(depth[2 * int(row), :, 0] * (2.0**24 - 1.0))
    length = 2.0 * AROUND * PLACES[int(row)] * (WIDTH - 1) / WIDTH
    return length / np.ptp(codes)


def steps(series, near):
    """The counted steps against the formula's.

    F is bent: over the strip, steps are AROUND² longer than in its middle. Counted codes may be off
    by three: half a code is rounded away at either end, and F itself is 2⁻²⁴ off in each of them.
    """
    for row, z in enumerate(PLACES):
        exact = float(depth_step(z, near, FAR))
        off = AROUND**2 + 3.0 * exact / (2.0 * AROUND * z)
        yield reading(
            z,
            reads={"depth": f"{'tenth' if near < 1 else 'one'}.depth"},
            given={"row": float(row)},
            between=((1.0 - off) * exact, (1.0 + off) * exact),
            series=series,
        )


def off_a_whole_number(depth, F):
    """How far depths of 16 bits are from whole numbers of steps, or from F by more than 0.6 steps.

    OpenGL lets either neighbour be stored, and prefers the nearest (4.6, 2.3.5.2); Direct3D bounds
    the error by 0.6 steps (11.3 functional specification, 3.2.3.6), which NVIDIA's driver uses.
    """
    codes, exact = (x.astype(np.float64) * (2.0**16 - 1.0) for x in (depth, F))
    return max(np.abs(codes - np.round(codes)).max(), np.abs(codes - exact).max() - 0.6)


def share(start, stop, near):
    """The share of all codes between two distances."""
    return window_depth(stop, near, FAR) - window_depth(start, near, FAR)


def largest_error(depth, F):
    """Depth buffer against formula."""
    return np.abs(depth - F).max()


FIXED = "steps of 16 bits are even: depth is a whole number of them"


KIND = call(
    "glGetFramebufferAttachmentParameteriv",
    *("GL_FRAMEBUFFER", "GL_DEPTH_ATTACHMENT", "GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE"),
)
KINDS = {"16": "UNSIGNED_NORMALIZED", "24": "UNSIGNED_NORMALIZED", "32F": "FLOAT"}
BITS = call("glGetRenderbufferParameteriv", "GL_RENDERBUFFER", "GL_RENDERBUFFER_DEPTH_SIZE")
CODE = call("glReadPixels", 0, 0, 1, 1, "GL_DEPTH_COMPONENT", "GL_UNSIGNED_SHORT")
THIRD = (call("glClearDepth", 1.0 / 3.0), call("glClear", "GL_DEPTH_BUFFER_BIT"))
GREY, DARK = (0.75, 0.75, 0.75, 1.0), (0.10, 0.13, 0.20, 1.0)
HALFWAY = {"aPos": (0.5, 0.0, 0.0), "middle": 10.0, "slope": 4.0}
AT_TWO = {"decade": 0.30102999566398, "near": 1.0}

case = Case(
    title="The precision of depth",
    section="6.2.2",
    math=r"F = \frac{1/z - 1/n}{1/f - 1/n}, \qquad \Delta z \approx "
    r"\frac{z^2}{2^b}\left(\frac 1n - \frac 1f\right)",
    passes=(
        strips("tenth", 0.1),
        strips("one", 1.0),
        strips("sixteen", 1.0, "depth16"),
        *enlarged((chart(0, 0.1), chart(1, 1.0)), (108, 54), 9, judged="judged"),
    ),
    picture="picture.FragColor",
    rows=("n = 1", "n = 0.1"),
    expect=[
        enlarged_check("judged"),
        *answers(
            {
                f"{bits} bits are kept": (
                    BITS,
                    int(bits[:2]),
                    depth_alone(f"GL_DEPTH_COMPONENT{bits}"),
                )
                for bits in KINDS
            }
        ),
        *answers(
            {
                f"depth of {bits} bits is GL_{kind}": (
                    KIND,
                    f"GL_{kind}",
                    depth_alone(f"GL_DEPTH_COMPONENT{bits}"),
                )
                for bits, kind in KINDS.items()
            }
        ),
        *answers(
            {
                "16 bits: ⅓ is the code 21845 of 65535": (
                    CODE,
                    (21845 & 0xFF, 21845 >> 8),
                    depth_alone("GL_DEPTH_COMPONENT16"),
                    THIRD,
                )
            }
        ),
        *each_draw("judged.depth", charted, enumerate(NEARS), "F with {}"),
        *each_draw("judged.FragColor", painted, enumerate(("lower", "upper")), "the {} chart"),
        *figures(
            "judged.FragColor",
            {
                **{line: ({"decade": x, "height": 0.5}, GREY) for line, x in LINES.items()},
                "just outside a line": (BESIDE, DARK),
                "just below the bar at the top": ({"decade": 0.5, "height": 0.98}, DARK),
            },
            reference=painted,
        ),
        formula("tenth.F", of_distance, name="F of a strip, n = 0.1"),
        formula("one.F", of_distance, name="F of a strip, n = 1"),
        formula("one.Distance", distance, name="the strip's distance"),
        formula("one.gl_Position", on_the_screen, name="the strip in clip space"),
        figure("one.Distance", "the distance between its middle and its edge", HALFWAY, 12.0),
        measure(
            "depth buffer against F",
            largest_error,
            readings=[
                reading("n = 0.1", reads={"depth": "tenth.depth", "F": "tenth.F"}),
                reading("n = 1", reads={"depth": "one.depth", "F": "one.F"}),
            ],
            at_most=1.0e-6,
            note="a step of the buffer is 6e-8, and so is one of a float below 1",
        ),
        measure(
            FIXED,
            off_a_whole_number,
            reads={"depth": "sixteen.depth", "F": "sixteen.F"},
            at_most=0.02,
            note="both are read as floats of 24 bits",
        ),
        measure(
            "distance of two steps",
            counted_step,
            readings=[r for series, near in NEARS.items() for r in steps(series, near)],
            x_label="z",
            y_label="Δz of a 24-bit depth buffer",
            log_x=True,
            log_y=True,
        ),
        figure("judged.depth", "F at z = 2 with n = 1", AT_TWO, 0.505051, draw=1),
        *results({"step at z = 50, n = 0.1": (depth_step(50.0, 0.1, FAR), 0.00148863)}, digits=8),
        *results({"step at z = 50, n = 1": (depth_step(50.0, 1.0, FAR), 0.000147521)}, digits=9),
        *results(
            {
                "z from 1 to 2, n = 1": (share(1.0, 2.0, 1.0), 0.505051),
                "z from 1 to 2, n = 0.1": (share(1.0, 2.0, 0.1), 0.050050),
                "z from 50 to 100, n = 1": (share(50.0, 100.0, 1.0), 0.010101),
                "z from 50 to 100, n = 0.1": (share(50.0, 100.0, 0.1), 0.001001),
            }
        ),
    ],
    errata=[
        Erratum(
            says="distances from 1 to 2 take half of the depth range",
            truth="50.5 % for n = 1 and f = 100, but 5.0 % for n = 0.1",
            proof="z from 1 to 2, n = 0.1",
        ),
        Erratum(
            says="distances from 50 to 100 take 2 % of the depth range",
            truth="1.0101 % for n = 1 and f = 100, 0.1001 % for n = 0.1",
            proof="z from 50 to 100, n = 1",
        ),
        Erratum(
            section="6.2",
            says="depth is stored as a float of 16 or 24 bits",
            truth="16 and 24 bits are fixed point, steps of 1 / (2ᵇ − 1) from 0 to 1; a float "
            "depth has 32 bits (GL_DEPTH_COMPONENT32F)",
            proof=FIXED,
        ),
    ],
)
