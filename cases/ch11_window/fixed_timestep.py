"""A fixed time step: the same motion, however long the frames take.

A loop that moves everything by the duration of the last frame gives another motion on every
machine, because a few large steps do not add up to many small ones. With a fixed step the duration
only goes into an account: as long as a whole step is in it, one is taken, and the rest waits for
the next frame. Then the state after n steps depends on n alone. Here the step is 1/64 second and
all numbers are binary fractions, so nothing is ever rounded and every state is exact.

Look at: a ball that bounces, one dot a frame, from left to right in time. Marks below the floor
show when the frames were. In the upper strip all 64 take 1/32 second, in the middle one some take
eight times as long as others, and yet their dots lie on the same arcs, which are grey behind them.
Below, the same uneven frames with steps as long as the frames are: the ball flies lower, and soon
bounces at other times.
"""

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Draw,
    Mesh,
    Output,
    Pass,
    Pixel,
    State,
    Target,
    computed,
    exact,
    fullscreen,
    up,
    value,
)

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
    return fullscreen(
        "ch11_window/fixed_timestep.frag",
        name=name,
        domain={},
        uniforms={"durations": durations, "fixedSteps": fixed, "dt": STEP},
        target=Target(size=(FRAMES, 1)),
    )


def dots(name, hue, size, cell, ticks=False):
    """A run's frames as points over time."""
    return Draw(
        vertex="ch11_window/fixed_timestep_picture.vert",
        fragment="ch11_window/fixed_timestep_picture.frag",
        mesh=Mesh(attributes={"frame": np.arange(FRAMES, dtype=float)}, primitive="points"),
        uniforms={"hue": hue, "ticks": ticks},
        textures={"run": Output(f"{name}.state")},
        state=State(cell=cell, point_size=size),
    )


def strip(k, name):
    """A run as dots over time, the even one's in grey behind them, and ticks for its frames."""
    cell = Cell(column=0, row=2 - k, columns=1, rows=3)
    floor = Draw(
        fragment="ch11_window/fixed_timestep_floor.frag",
        domain={"height": up(-0.15, 1.1)},
        state=State(cell=cell),
    )
    return (
        floor,
        dots("even", (0.16, 0.18, 0.21), 12.0, cell),
        dots(name, HUES[name], 10.0, cell),
        dots(name, (0.6, 0.6, 0.6), 5.0, cell, ticks=True),
    )


def at_common_times():
    """The largest difference of two fixed runs wherever both have a frame and nothing left over."""
    one, other = (states(*RUNS[name]) for name in ("even", "uneven"))
    common = [(a, b) for a in one for b in other if a[0] == b[0] and a[3] == b[3]]
    return (len(common), max(np.abs(a - b).max() for a, b in common))


def rounded(name):
    """How much a run would lose as float32: nothing, so that every device must agree."""
    exactly = states(*RUNS[name])
    return np.abs(exactly - exactly.astype(np.float32)).max()


case = Case(
    title="A fixed time step",
    section="11.3",
    math=r"v_{k+1} = v_k - g\,\Delta t, \qquad y_{k+1} = y_k + v_{k+1}\,\Delta t, \qquad "
    r"k = \lfloor t / \Delta t \rfloor",
    passes=(
        *(p for name in RUNS for p in run(name)),
        Pass(
            name="picture",
            target=Target(size=(1000, 600)),
            draws=tuple(d for k, name in enumerate(RUNS) for d in strip(k, name)),
        ),
    ),
    picture="picture.FragColor",
    expect=[
        *(
            exact(
                f"{name}.state",
                states(*RUNS[name])[None].astype(np.float32),
                name=f"every frame of the {name} run",
            )
            for name in RUNS
        ),
        *(
            computed(
                f"what the {name} run loses in float32",
                lambda name=name: rounded(name),
                equals=0.0,
                digits=12,
            )
            for name in RUNS
        ),
        computed(
            "common times, and the largest difference there",
            at_common_times,
            equals=(8.0, 0.0),
            digits=6,
        ),
        *(
            value(
                f"{name}.state",
                at=Pixel(FRAMES - 1, 0),
                equals=AFTER[name],
                digits=6,
                name=f"the {name} run after two seconds",
            )
            for name in RUNS
        ),
    ],
)
