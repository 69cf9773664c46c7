"""A model of two buffers in turn: the screen never shows a frame that is only half drawn.

A frame takes many draws, and the screen refreshes at any time. With one buffer it is read in the
middle of the next frame: first the sky has been painted over everything, then, a moment later, the
ball is there again, and the ball flickers. With two, the draws go into the back buffer while the
screen reads the front one, and the two swap roles when the frame is done. The screen is at most one
frame late, and always shows a whole frame.

The window system does the swapping, and there is no window here. Two targets, created once and
drawn into in turn, stand in for the front and the back buffer, and a copy stands in for the screen.

Look at: seven refreshes while a ball rolls to the right, from left to right in time: every second
one comes in the middle of a frame. Above, with one buffer, those (framed red) show the sky alone.
Below, with two, they show the last whole frame once more.

Try: in `ch11_window/double_buffer_sky.frag` write `if (place.x > 0.0) discard; vec3 sky` for `vec3
sky`: nothing is painted over on the right, and the ball that was drawn there before stays.
"""

import numpy as np

from shaderlab import Case, Output, Pass, Target, coverage, exact, formula, gl_calls
from shaderlab.glslmath import abs, dot, max, mix, swizzle, vec3, vec4, where
from shaderlab.glslmath.sampling import texture

from ..scenes.figures import each_draw, figure, figures
from ..scenes.panel_checks import enlarged_check, parts_check
from ..scenes.panels import cell, centres, enlarged, panel, square

FRAMES = 4
SMALL = Target(size=(96, 96))
WINDOW = {"place": square()}


def sky_draw():
    """The first draw of a frame, over all that was there."""
    return panel("ch11_window/double_buffer_sky.frag", WINDOW)


def ball_draw(frame):
    """The second one: the ball where it is in this frame."""
    uniforms = {"middle": (-0.6 + 0.4 * frame, -0.2)}
    return panel("ch11_window/double_buffer_ball.frag", WINDOW, uniforms)


def shown(name, front):
    """One refresh of the screen: it copies the buffer that it is pointed at."""
    textures = {"front": Output(f"{front}.FragColor")}
    screen = panel("ch11_window/double_buffer_screen.frag", {}, textures=textures)
    return Pass(name=name, target=SMALL, draws=(screen,))


def one_buffer():
    """Every frame into the same target, which the screen reads after each draw."""
    passes = [Pass(name="one 0", target=SMALL, draws=(sky_draw(), ball_draw(0)))]
    passes.append(shown("one seen 0", "one 0"))
    for k in range(1, FRAMES):
        half, whole = f"one {k} half", f"one {k}"
        before = passes[-2].name
        passes.append(Pass(name=half, target=SMALL, draws=(sky_draw(),), onto=before))
        passes.append(shown(f"one seen {2 * k - 1}", half))
        passes.append(Pass(name=whole, target=SMALL, draws=(ball_draw(k),), onto=half))
        passes.append(shown(f"one seen {2 * k}", whole))
    return passes


def two_buffers():
    """Frames into two targets in turn; the screen reads the one that is not drawn into."""
    passes = [Pass(name="two 0", target=SMALL, draws=(sky_draw(), ball_draw(0)))]
    passes.append(shown("two seen 0", "two 0"))
    for k in range(1, FRAMES):
        half, whole, front = f"two {k} half", f"two {k}", f"two {k - 1}"
        back = f"two {k - 2}" if k > 1 else ""  # the second buffer is made for the second frame
        passes.append(Pass(name=half, target=SMALL, draws=(sky_draw(),), onto=back))
        passes.append(shown(f"two seen {2 * k - 1}", front))
        passes.append(Pass(name=whole, target=SMALL, draws=(ball_draw(k),), onto=half))
        passes.append(shown(f"two seen {2 * k}", whole))
    return passes


def framed(place, name, edge):
    """A refresh as part of the strip."""
    return panel(
        "ch11_window/double_buffer_picture.frag",
        {"place": square(0.0, 1.0)},
        {"edge": edge},
        textures={"seen": Output(f"{name}.FragColor")},
        cell=cell(place, 2 * FRAMES - 1, 2),
    )


def copied(place, seen, edge):
    """A refresh in its frame."""
    off = abs(place - 0.5)
    shown = swizzle(texture(seen, (place - 0.5) / 0.92 + 0.5), "xyz")
    outside = max(swizzle(off, "x"), swizzle(off, "y")) > 0.46
    return vec4(where(outside, edge, shown), 1.0)


def sky(place):
    """From warm at the horizon to blue, over dark ground."""
    height = swizzle(place, "y")
    color = mix(vec3(0.80, 0.62, 0.52), vec3(0.22, 0.34, 0.55), 0.5 + 0.5 * height)
    return vec4(where(height < -0.5, vec3(0.16, 0.24, 0.20), color), 1.0)


def ball(place, middle):
    """Lit from the upper left."""
    light = 0.5 + 0.5 * dot((place - middle) / 0.3, np.array([-0.5, 0.5]))
    return vec4(light * vec3(1.0, 0.86, 0.32), 1.0)


def beside(place, middle):
    """What is thrown away around the ball."""
    off = (place - middle) / 0.3
    return dot(off, off) > 1.0


def disc(frame):
    """How many pixels' centres lie in the ball."""
    off = (centres(96) - (-0.6 + 0.4 * frame, -0.2)) / 0.3
    return int((np.sum(off * off, axis=-1) <= 1.0).sum())


REFRESHES = range(2 * FRAMES - 1)
STRIP = [f"{buffers} {k}" for buffers in ("two", "one") for k in REFRESHES]
HALF_DRAWN = [f"one {k}" for k in REFRESHES if k % 2]
# Where each of them is in the picture, within its frame.
PLACES = {
    f"{name[:3]} seen {name[4:]}.FragColor": tuple(
        (number + off) / count
        for off in (0.04, 0.96)
        for number, count in ((k % len(REFRESHES), len(REFRESHES)), (k // len(REFRESHES), 2))
    )
    for k, name in enumerate(STRIP)
}
DARK, RED = (0.07, 0.08, 0.10), (0.85, 0.20, 0.15)

case = Case(
    title="Double buffering, a model",
    section="11.2",
    math=r"\text{front}_{k+1} = \text{back}_k, \qquad \text{back}_{k+1} = \text{front}_k",
    passes=(
        Pass(name="sky alone", target=SMALL, draws=(sky_draw(),)),
        *(
            Pass(name=f"frame {k}", target=SMALL, draws=(sky_draw(), ball_draw(k)))
            for k in range(FRAMES)
        ),
        *one_buffer(),
        *two_buffers(),
        *enlarged(
            [
                framed(k, f"{seen[:3]} seen {seen[4:]}", RED if seen in HALF_DRAWN else DARK)
                for k, seen in enumerate(STRIP)
            ],
            (210, 60),
            5,
        ),
    ),
    picture="picture.FragColor",
    rows=("one buffer", "two buffers"),
    expect=[
        parts_check(PLACES, at_most=0.03),
        *each_draw("small.FragColor", copied, {k: f"shown: {s}" for k, s in enumerate(STRIP)}),
        enlarged_check(edges=0.001),
        *(
            formula(f"frame {k}.FragColor", ball, discards=beside, name=f"the ball in frame {k}")
            for k in range(FRAMES)
        ),
        *(
            coverage(disc(k), pass_name=f"frame {k}", name=f"pixels of the ball in frame {k}")
            for k in range(FRAMES)
        ),
        formula("frame 0.FragColor", sky, draw=0, name="the sky behind it"),
        formula("sky alone.FragColor", sky, name="the sky alone"),
        # No pixel centre lies where the ground begins.
        *figures(
            "sky alone.FragColor",
            {
                "the horizon is sky": ({"place": (0.0, -0.5)}, (0.655, 0.55, 0.5275, 1.0)),
                "just below it is ground": ({"place": (0.0, -0.503)}, (0.16, 0.24, 0.20, 1.0)),
            },
        ),
        figure(
            "frame 0.FragColor",
            "the ball's lit side",
            {"place": (-0.75, -0.05), "middle": (-0.6, -0.2)},
            (0.75, 0.645, 0.24, 1.0),
        ),
        *(
            exact(
                f"two seen {k}.FragColor",
                Output(f"frame {k // 2}.FragColor"),
                name=f"two buffers, refresh {k}: frame {k // 2}, whole",
            )
            for k in REFRESHES
        ),
        *(
            gl_calls(
                "glGenFramebuffers",
                times=int(k < 2),
                pass_name=f"two {k} half" if k else "two 0",
                name=f"frame {k} goes into the " + ("next buffer" if k < 2 else "one before last"),
            )
            for k in range(FRAMES)
        ),
        *(
            gl_calls(
                "glGenFramebuffers",
                times=0,
                pass_name=f"one {k} half",
                name=f"one buffer: frame {k} goes into it",
            )
            for k in range(1, FRAMES)
        ),
        *(
            exact(
                f"one seen {k}.FragColor",
                Output((f"frame {k // 2}" if k % 2 == 0 else "sky alone") + ".FragColor"),
                name=f"one buffer, refresh {k}: " + ("half drawn" if k % 2 else "whole"),
            )
            for k in REFRESHES
        ),
    ],
)
