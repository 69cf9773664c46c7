"""Compute shaders: many work at once, share what they found, and wait for each other.

Running sums look sequential: each needs the one before. But if each of 256 numbers adds the one
that is 1, 2, 4 … places to its left, all sums are complete after eight rounds, exactly. A Fourier
transform of 128 numbers takes seven rounds of 64 pairs instead of 128² products. Between the rounds
stands a barrier: nothing is read before it has been written. The checks need no second transform:
one bright point becomes a wave of the same strength everywhere, and the total strength does not
change (Parseval). Where particles attract each other, each pull has its opposite, so the sum of
their speeds does not change either.

Look at: an opening with six blades, and a bright lamp seen through it. The light is bent by the
square of its Fourier transform, red more than blue.

Try: in `ch15_beyond/starburst.frag` write `light(1.0), light(1.0), light(1.0)` for `light(1.2),
light(1.0), light(0.84)`: light of one colour.

Compute shaders came with OpenGL 4.3; softpipe, WebGL2 and the lab's Vulkan have none.
"""

import math

import numpy as np

from shaderlab import Case, Output, Texture, compute, exact, formula, measure
from shaderlab.glslmath import dot, floor, int, log, swizzle, vec4
from shaderlab.glslmath.sampling import texelFetch, texture

from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, square

SIZE = 128
TURNS = -2.0 * math.pi * np.arange(SIZE // 2) / SIZE
ROOTS = np.column_stack([np.cos(TURNS), np.sin(TURNS)])
RANDOM = np.random.default_rng(12)
NUMBERS = RANDOM.integers(0, 2**32, 256, dtype=np.uint64)
SUMS = np.cumsum(NUMBERS) % 2**32
PLACES, SPEEDS = RANDOM.uniform(-1.0, 1.0, (64, 2)), RANDOM.uniform(-0.1, 0.1, (64, 2))
SMOOTH = {"filter": ("linear", "linear"), "wrap": ("clamp_to_edge", "clamp_to_edge")}


def opening():
    """An opening with six blades, soft by a texel; real numbers."""
    y, x = (np.mgrid[0:SIZE, 0:SIZE] - 63.5) / 64.0
    turns = np.radians(60.0 * np.arange(6) + 8.0)
    edge = np.max([x * np.cos(t) + y * np.sin(t) for t in turns], axis=0)
    return np.clip((0.30 - edge) * 64.0 + 0.5, 0.0, 1.0)


def complex_image(values):
    """Complex numbers as an image of two channels."""
    return np.stack([np.real(values), np.imag(values)], axis=-1)


NOISE = RANDOM.normal(size=(SIZE, SIZE)) + 1j * RANDOM.normal(size=(SIZE, SIZE))
POINT = np.zeros((SIZE, SIZE))
POINT[5, 9] = 1.0
IMAGES = {"opening": opening(), "noise": NOISE, "point": POINT}


def transformed(name):
    """Passes over the rows and then the columns of an image."""
    before, empty = complex_image(IMAGES[name]), np.zeros((SIZE, SIZE, 2))
    for kind, upright in (("rows", False), ("columns", True)):
        yield from compute(
            "ch15_beyond/fft.comp",
            groups=(SIZE, 1, 1),
            name=f"{name}_{kind}",
            images={"before": before, "after": empty},
            uniforms={"upright": upright, "roots": ROOTS},
        )
        before = Output(f"{name}_{kind}.after")


def shown(far, at):
    """A panel of the picture."""
    opening = np.repeat(IMAGES["opening"][..., None], 4, axis=-1)
    textures = {
        "aperture": Texture(image=opening, **SMOOTH),
        "spectrum": Output("opening_columns.after"),
    }
    of = {"textures": textures, "cell": at}
    return panel("ch15_beyond/starburst.frag", {"place": square()}, {"far": far}, **of)


def light(place, spectrum, wavelength):
    """The light of one wavelength, by the square of the transform."""
    at = floor(place * 56.0 / wavelength + 0.5)
    at = int(at - 128.0 * floor(at / 128.0))
    wave = swizzle(texelFetch(spectrum, at, 0), "xy")
    return log(1.0 + 0.02 * dot(wave, wave)) / 9.0


def starburst(place, spectrum):
    """A lamp through the opening."""
    return vec4(*(light(place, spectrum, wavelength) for wavelength in (1.2, 1.0, 0.84)), 1.0)


def blades(place, aperture):
    """The opening itself."""
    seen = swizzle(texture(aperture, 0.5 * place + 0.5), "x")
    return vec4(seen, seen, seen, 1.0)


def from_numpy(axes):
    """How far a transform of noise is from NumPy's, by its largest number."""

    def furthest(after):
        truth = np.fft.fftn(NOISE, axes=axes)
        return np.abs(after[..., 0] + 1j * after[..., 1] - truth).max() / np.abs(truth).max()

    return furthest


def from_parseval(after):
    """How much of the strength of noise is lost or won."""
    return abs((after**2).sum() / (SIZE**2 * (np.abs(NOISE) ** 2).sum()) - 1.0)


def from_one(after):
    """How far the transform of a point is from strength 1."""
    return np.abs(np.hypot(after[..., 0], after[..., 1]) - 1.0).max()


def from_pulls(speeds):
    """How far speeds are from the sums of all pulls."""
    off = PLACES[None] - PLACES[:, None]
    square = (off**2).sum(axis=-1, keepdims=True) + 0.04
    return np.abs(speeds[0] - SPEEDS - 0.01 * (off / square**1.5).sum(axis=1)).max()


def momentum(speeds):
    """How much the sum of all speeds changes."""
    return np.abs((speeds[0] - SPEEDS).sum(axis=0)).max()


SPECTRUM, PULLED = {"after": "noise_columns.after"}, {"speeds": "particles.speeds"}

case = Case(
    title="Compute shaders",
    section="15.16",
    math=r"s_k = \sum_{i \le k} n_i, \qquad F_k = \sum_i f_i\,e^{-2\pi\mathrm{i}\,ik / N}, \qquad "
    r"\sum |F|^2 = N \sum |f|^2, \qquad \sum v = \mathrm{const}",
    passes=(
        *compute(
            "ch15_beyond/scan.comp",
            groups=(1, 1, 1),
            name="scan",
            buffers={"numbers": NUMBERS, "sums": np.zeros(256, np.uint32)},
        ),
        *compute(
            "ch15_beyond/particles.comp",
            groups=(1, 1, 1),
            name="particles",
            buffers={"places": PLACES, "speeds": SPEEDS},
            uniforms={"time": 0.01},
        ),
        *(one for name in IMAGES for one in transformed(name)),
        *enlarged([shown(k == 1, cell(k, 2)) for k in (0, 1)], (56, 28), 9),
    ),
    picture="picture.FragColor",
    columns=("the opening", "the lamp through it"),
    expect=[
        exact("scan.sums", SUMS, name="sums from the left"),
        measure("from the sums of pulls", from_pulls, reads=PULLED, at_most=2.0**-16),
        measure("the sum of all speeds", momentum, reads=PULLED, at_most=2.0**-16),
        measure(
            "rows, by NumPy", from_numpy((1,)), reads={"after": "noise_rows.after"}, at_most=1e-6
        ),
        measure("both, by NumPy", from_numpy((0, 1)), reads=SPECTRUM, at_most=1e-6),
        measure("Parseval", from_parseval, reads=SPECTRUM, at_most=1e-6),
        measure("a point", from_one, reads={"after": "point_columns.after"}, at_most=1e-6),
        formula("small.FragColor", blades, draw=0, name="an opening"),
        formula("small.FragColor", starburst, draw=1, name="a lamp through it"),
        enlarged_check(),
    ],
)
