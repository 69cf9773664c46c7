"""A fixed time step: the same motion, however long the frames take.

A loop that moves everything by the duration of the last frame gives a different motion on every
machine, because a few large steps do not add up to many small ones. With a fixed step the duration
goes into an accumulator: while it holds a whole step, one step is taken, and the rest waits for the
next frame. Then the state after n steps depends on n alone. Here the step is 1/64 second and all
numbers are binary fractions, so nothing is ever rounded and every state is exact.

Look at: a ball that bounces, one dot a frame, from left to right in time. Marks below the floor
show when the frames were. In the upper strip, all 64 take 1/32 second; in the middle one, some take
eight times as long as others. Yet the dots of both lie on the same arcs, drawn in grey behind them.
The lowest strip has the same uneven frames, but each step is as long as its frame: the ball flies
lower, and soon bounces at other times.

Try: in `ch11_window/fixed_timestep.frag` write `-speed` for `-0.75 * speed`: with fixed steps the
ball loses nothing, and rises about as high each time.
"""

import numpy as np

from shaderlab import Case, Mesh, Output, Pixel, boundaries, exact, query, up
from shaderlab.glslmath import length, swizzle, vec2, vec3, vec4, where
from shaderlab.glslmath.sampling import texelFetch

from ..scenes.drawing import encoded
from ..scenes.draws import tested
from ..scenes.figures import each_draw, figure, results
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, panel, panel_pass, picture

FRAMES = 64
STEP = 1.0 / 64.0
EVEN = np.full(FRAMES, 8.0) / 256.0
# 2 to 16 parts of 1/256 second, eight frames that come again and again.
UNEVEN = np.tile([2.0, 16.0, 5.0, 11.0, 3.0, 13.0, 9.0, 5.0], FRAMES // 8) / 256.0
RUNS = {"even": (EVEN, True), "uneven": (UNEVEN, True), "variable": (UNEVEN, False)}
# Time, height, speed and what is left over after two seconds.
AFTER = {
    "even": (2.0, 0.183594, 0.1875, 0.0),
    "uneven": (2.0, 0.183594, 0.1875, 0.0),
    "variable": (2.0, 0.184189, -0.267090, 0.0),
}
HUES = {"even": (0.20, 0.62, 0.35), "uneven": (0.25, 0.50, 0.95), "variable": (0.95, 0.30, 0.16)}


# The dots of a strip: the even run's, its own, and the ticks'; and how large a pixel is. Sizes are
# whole: glPointSize's are rounded to whole pixels by NVIDIA's driver, as OpenGL 2.1 demanded.
SIZES, PIXELS = (3.0, 2.0, 1.0), {"picture": 3.0, "small": 1.0}


def moved(height, speed, seconds):
    """One step: the speed first, then the height with the new speed."""
    speed -= 8.0 * seconds
    height += speed * seconds
    return (-height, -0.75 * speed) if height < 0.0 else (height, speed)


def states(durations, fixed):
    """Time, height, speed and what is left over after each frame, in float64."""
    time, height, speed, left = 0.0, 1.0, 0.0, 0.0
    found = []
    for duration in durations:
        time += duration
        left += duration if fixed else 0.0
        if not fixed:
            height, speed = moved(height, speed, duration)
        while left >= STEP:
            height, speed = moved(height, speed, STEP)
            left -= STEP
        found.append((time, height, speed, left))
    return np.array(found)


def run(name):
    """One pixel for each frame of a run."""
    durations, fixed = RUNS[name]
    uniforms = {"durations": durations, "fixedSteps": fixed, "dt": STEP}
    return panel_pass(name, "ch11_window/fixed_timestep.frag", {}, uniforms, size=(FRAMES, 1))


def dots(name, hue, size, place, ticks=False):
    """A run's frames as points over time."""
    return tested(
        "ch11_window/fixed_timestep_picture",
        Mesh(attributes={"frame": np.arange(FRAMES, dtype=float)}, primitive="points"),
        {"hue": hue, "ticks": ticks},
        textures={"run": Output(f"{name}.state")},
        cell=place,
        depth=None,
        point_size=size,
    )


def strips(name, size, pixel):
    """All three runs as dots over time, the even one's in grey behind them, and ticks for frames.

    Points are so many pixels large as `pixel` is.
    """
    draws = []
    for k, run in enumerate(RUNS):
        place = cell(k, 1, 3, from_above=True)
        floor = "ch11_window/fixed_timestep_floor.frag"
        draws += [
            panel(floor, {"height": up(-0.15, 1.1)}, cell=place),
            dots("even", (0.16, 0.18, 0.21), SIZES[0] * pixel, place),
            dots(run, HUES[run], SIZES[1] * pixel, place),
            dots(run, (0.6, 0.6, 0.6), SIZES[2] * pixel, place, ticks=True),
        ]
    return picture(draws, size, name)


def ground(height):
    """Darker above the floor than below it."""
    below, above = vec3(0.10, 0.11, 0.13), vec3(0.025, 0.032, 0.045)
    return vec4(encoded(where(height < 0.0, below, above)), 1.0)


def dot_color(hue):
    """A dot of one colour."""
    return vec4(encoded(hue), 1.0)


def outside(gl_PointCoord):
    """Only the disc in each point's square is kept."""
    return length(gl_PointCoord - 0.5) > 0.5


def frame_place(frame, run, ticks):
    """A frame's time to the right and its height upward, or a mark below the floor."""
    seen = texelFetch(run, vec2(frame, 0.0), 0)
    height = where(ticks > 0.5, -0.075, swizzle(seen, "y"))
    x, y = (swizzle(seen, "x") + 0.03) / 2.08, (height + 0.15) / 1.25
    return vec4(2.0 * x - 1.0, 2.0 * y - 1.0, 0.0, 1.0)


def disc_areas(pixel):
    """Each draw of dots, and the area of its discs, in pixels. As points lie anywhere on the grid
    of pixels, about as many samples are in them."""
    return [(k, FRAMES * np.pi / 4.0 * (SIZES[k % 4 - 1] * pixel) ** 2) for k in PARTS]


def at_common_times():
    """The largest difference of two fixed runs wherever both have a frame and nothing left over."""
    one, other = (states(*RUNS[name]) for name in ("even", "uneven"))
    common = [(a, b) for a in one for b in other if a[0] == b[0] and a[3] == b[3]]
    return (len(common), max(np.abs(a - b).max() for a, b in common))


def rounded(name):
    """How much a run would lose as float32: nothing, so that every device must agree."""
    exactly = states(*RUNS[name])
    return np.abs(exactly - exactly.astype(np.float32)).max()


PARTS = {
    4 * k + n: f"{part} of strip {k}"
    for k in range(3)
    for n, part in enumerate(("even dots", "dots", "ticks"), 1)
}

case = Case(
    title="A fixed time step",
    section="11.3",
    math=r"v_{k+1} = v_k - g\,\Delta t, \qquad y_{k+1} = y_k + v_{k+1}\,\Delta t, \qquad "
    r"k = \lfloor t / \Delta t \rfloor",
    passes=(
        *map(run, RUNS),
        strips("picture", (600, 360), PIXELS["picture"]),
        strips("small", (200, 120), PIXELS["small"]),
    ),
    picture="picture.FragColor",
    rows=("even frames", "uneven frames", "uneven steps"),
    expect=[
        # Of 576 points, two pixels each change within 1/256 of a pixel, to either side.
        enlarged_check(edges=576 * 2 * (2 / 256) / (200 * 120)),
        *each_draw("small.FragColor", ground, {4 * k: f"strip {k}" for k in range(3)}),
        boundaries("small.FragColor", ground, draw=0, name="the floor's edge"),
        *each_draw("small.FragColor", dot_color, PARTS, discards=outside),
        *each_draw(
            "picture.FragColor",
            dot_color,
            {k: f"{part}, enlarged" for k, part in PARTS.items()},
            discards=outside,
        ),
        *(
            query(
                "samples_passed",
                at_least=int(0.8 * area),
                at_most=int(1.28 * area),
                pass_name=name,
                draw=k,
                name=f"{name}: as many samples as the discs are large, {PARTS[k]}",
            )
            for name, pixel in PIXELS.items()
            for k, area in disc_areas(pixel)
        ),
        *each_draw(
            "picture.gl_Position",
            frame_place,
            {k: f"places of {part}, enlarged" for k, part in PARTS.items()},
        ),
        *each_draw(
            "small.gl_Position", frame_place, {k: f"places of {part}" for k, part in PARTS.items()}
        ),
        *(
            exact(
                f"{name}.state",
                states(*RUNS[name])[None].astype(np.float32),
                name=f"every frame of the {name} run",
            )
            for name in RUNS
        ),
        *results(
            {f"what the {name} run loses in float32": (rounded(name), 0.0) for name in RUNS},
            digits=12,
        ),
        *results({"common times, and the largest difference there": (at_common_times, (8.0, 0.0))}),
        *(
            figure(
                f"{name}.state", f"the {name} run after two seconds", Pixel(FRAMES - 1, 0), after
            )
            for name, after in AFTER.items()
        ),
    ],
)
