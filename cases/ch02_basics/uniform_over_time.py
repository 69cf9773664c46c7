"""A uniform that changes with time: the program computes a colour, the shader shows it.

The green channel swings as sin(t)/2 + 0.5, from 0 to 1. What the program sends before each draw
arrives exactly; of a sine that the shader computes, GLSL bounds no error, and Vulkan one of 2⁻¹¹.

Look at: the bead, which is filled with the uniform of that moment, riding on the curve.

Try: in `ch02_basics/uniform_over_time_picture.frag` write `sin(2.0 * place.x)` for `sin(place.x)`:
the curve swings twice as fast, and the bead, which goes by the uniform, leaves it.
"""

from functools import partial
from math import pi, sin

import numpy as np

from shaderlab import Case, Rules, Variant, exact, formula, fullscreen, sweep, value
from shaderlab.glslmath import length, swizzle, vec2, vec3, vec4, where

from ..scenes.drawing import pixel_size, with_lines
from ..scenes.figures import figure
from ..scenes.laws import unchanged
from ..scenes.panels import rectangle
from ..scenes.waves import pulse

FRAMES = [("0", 0.0, 0.5), ("1", 1.0, 0.920735), ("2", 2.0, 0.954649), ("3", 3.0, 0.570560)]
FRAMES += [("1.5708 (π÷2)", pi / 2, 1.0), ("4.7124 (3π÷2)", 3 * pi / 2, 0.0)]

# Past π the specification promises nothing of a sine; the conformance suite allows |t|·2⁻¹².
LATER = Rules(trig_outside="scaled")
GREY, PALE, WHITE = (0.30,) * 3, (0.85,) * 3, (1.0,) * 3
START = (-0.4, -0.3)  # time and green in the picture's corner


def sent(time):
    """What a render loop sends."""
    return {"time": time, "ourColor": (0.0, sin(time) / 2.0 + 0.5, 0.0, 1.0)}


def painted(place, ourColor, time, frag_coord, corner=START):
    """The curve over the colour of each moment, and the bead on it, which is the uniform."""
    x, y, size = swizzle(place, "x"), swizzle(place, "y"), pixel_size(place, corner, frag_coord)
    green = pulse(x)
    past = vec3(0.0, green, 0.0) * where(x < time, 0.75, 0.30)
    color = where((y < green) & (y > 0.0), past, vec3(0.07, 0.08, 0.10))

    def bead(place):
        return length((place - vec2(time, swizzle(ourColor, "g"))) * vec2(0.2254, 1.0)) - 0.075

    lines = (
        (lambda place: swizzle(place, "y"), 1.0, GREY, 1.0),
        (lambda place: swizzle(place, "y") - 1.0, 1.0, GREY, 1.0),
        (lambda place: swizzle(place, "y") - pulse(swizzle(place, "x")), 2.0, PALE, 1.0),
        (lambda place: swizzle(place, "x") - time, 1.0, PALE, 0.5),
    )
    curve = with_lines(color, place, size, lines)
    color = where(bead(place) < 0.0, swizzle(ourColor, "rgb"), curve)
    return vec4(with_lines(color, place, size, [(bead, 2.5, WHITE, 1.0)]), 1.0)


def picture(corner, extent, moment):
    """The curve in a part of the plane."""
    shader, domain = "ch02_basics/uniform_over_time_picture.frag", rectangle(corner, extent)
    return fullscreen(shader, name="picture", domain={"place": domain}, uniforms=moment)


def frame(name, time, green):
    """The picture at one moment, with the figure the formula gives then."""
    moment = sent(time)
    return Variant(
        f"t = {name}",
        moment,
        expect=[
            formula("picture.FragColor", painted, rules=LATER, name="the curve and the bead"),
            exact("FragColor", np.float32(moment["ourColor"]), name="the uniform arrives exactly"),
            value("green", at={"time": time}, equals=green, digits=6, rules=LATER),
        ],
    )


OTHER, ANOTHER = (0.25, 0.5, 0.75, 1.0), "another colour arrives as well"
moment, bead = sent(0.0), sent(2.5)
# The bead's radius is a third of this part's width, and of its height.
EXTENT = (1.0, 0.2254)
NEAR = (bead["time"] - 0.5 * EXTENT[0], bead["ourColor"][1] - 0.5 * EXTENT[1])
FROM_NEAR = partial(painted, corner=NEAR)
MAIN = fullscreen("ch02_basics/uniform_over_time.frag", domain={}, uniforms=moment)

case = Case(
    title="A uniform over time",
    section="2.3.4",
    math=r"g(t) = \tfrac12 \sin t + \tfrac12",
    passes=(*picture(START, (7.1, 1.6), moment), *MAIN),
    picture="picture.FragColor",
    expect=[
        formula("green", pulse, rules=LATER),
        figure("FragColor", ANOTHER, {"ourColor": OTHER}, OTHER, reference=unchanged("ourColor")),
        sweep("green", pulse, over="time", values=np.linspace(0.0, 2 * pi, 65), rules=LATER),
        value("green", at={"time": 103.0}, equals=0.811494, digits=6, rules=LATER, name="later"),
    ],
    variants=[
        *(frame(*row) for row in FRAMES),
        Variant(
            "the bead at t = 2.5",
            bead,
            passes=(*picture(NEAR, EXTENT, bead), *MAIN),
            expect=[formula("picture.FragColor", FROM_NEAR, rules=LATER, name="from near by")],
        ),
    ],
)
