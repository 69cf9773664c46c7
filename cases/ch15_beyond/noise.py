"""Noise: random, but the same at the same place, and smooth between.

Random numbers stand at the points of a lattice; a hash makes them of the point's coordinates. Value
noise mixes the numbers themselves, gradient noise slopes: it is 0 at every lattice point, and stays
within ±√(n/4) in n dimensions. Octaves, each twice as fine and half as strong, make clouds and
coasts of it; noise that shifts the place where noise is read makes marble.

The hash decides whether devices agree. PCG works on integers and is exact. The best-known one,
fract(sin(dot(p, vec2(12.9898, 78.233))) * 43758.5453), is anything: GLSL states no bound for sin,
Vulkan 2⁻¹¹, and that times 43758 is 21 whole turns.

Look at: value noise, which shows its squares, and gradient noise above; octaves and marble below.

Try: in `lib/noise.glsl` write `part * part * (3.0 - 2.0 * part)` for
`part * part * part * (part * (part * 6.0 - 15.0) + 10.0)`: faint creases show along the lattice.
"""

import math

import numpy as np

from shaderlab import Case, exact, formula, measure
from shaderlab.glslmath import (
    array,
    clamp,
    dot,
    float,
    floor,
    fract,
    int,
    mix,
    smoothstep,
    swizzle,
    uint,
    vec2,
    vec3,
    vec4,
)

from ..scenes.figures import figures, results
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, panel_pass, rectangle

SHADER = "ch15_beyond/noise.frag"
HALF = 0.70710678
SLOPES = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]
SLOPES += [(HALF, HALF), (-HALF, HALF), (-HALF, -HALF), (HALF, -HALF)]
BOUND = math.sqrt(2.0 / 4.0)
# Kinds by number, and how many cells wide they are shown.
KINDS = ("value noise", "gradient noise", "octaves", "marble")
CELLS = (7.0, 7.0, 3.1, 2.0)


def pcg(seed):
    """PCG's output of one step, of 32 bits."""
    state = seed * uint(747796405) + uint(2891336453)
    word = ((state >> ((state >> uint(28)) + uint(4))) ^ state) * uint(277803737)
    return (word >> uint(22)) ^ word


def pcg_by_hand(seed):
    """The same by Python's integers."""
    state = (seed * 747796405 + 2891336453) % 2**32
    word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737 % 2**32
    return (word >> 22) ^ word


def faded(part):
    """Perlin's curve, 6t⁵ − 15t⁴ + 10t³."""
    return part * part * part * (part * (part * 6.0 - 15.0) + 10.0)


def lattice(place, at):
    """Noise of what `at` gives at a cell's corners, by their hash and the way from there."""
    x, y = (floor(swizzle(place, name)) for name in "xy")
    off = fract(place)
    part = faded(off)

    def corner(right, above):
        hashed = pcg(uint(int(x) + right) + pcg(uint(int(y) + above)))
        return at(hashed, off - np.array([right, above]))

    across, up = swizzle(part, "x"), swizzle(part, "y")
    lower = mix(corner(0, 0), corner(1, 0), across)
    return mix(lower, mix(corner(0, 1), corner(1, 1), across), up)


def value_noise(place):
    """Numbers, mixed."""
    return lattice(place, lambda hashed, _: float(hashed >> uint(8)) / 8388608.0 - 1.0)


def gradient_noise(place):
    """Slopes, mixed."""
    table = array(*(vec2(*slope) for slope in SLOPES))
    return lattice(place, lambda hashed, off: dot(table[hashed & uint(7)], off))


def octaves(place):
    """Four octaves of gradient noise."""
    total = 0.0
    for k in range(4):
        total = total + 0.5**k * gradient_noise(place)
        place = 2.0 * place + 17.5
    return total


def marble(place):
    """Octaves at a place that octaves shift."""
    return octaves(place + 1.5 * vec2(octaves(place + 5.25), octaves(place + 9.75)))


LEVELS = (value_noise, gradient_noise, octaves, marble)


def coast(level):
    """The colours that levels are shown in."""

    def color(place):
        shade = clamp(0.5 + 0.62 * level(place), 0.0, 1.0)
        sea = mix(vec3(0.02, 0.09, 0.20), vec3(0.10, 0.47, 0.55), smoothstep(0.0, 0.45, shade))
        foam = mix(sea, vec3(0.97, 0.92, 0.80), smoothstep(0.35, 0.65, shade))
        return vec4(mix(foam, vec3(0.72, 0.30, 0.13), smoothstep(0.6, 1.0, shade)), 1.0)

    return color


def noise(kind, at):
    """A panel of one kind of noise."""
    side = CELLS[kind]
    domain = {"place": rectangle((-2.0, -1.0), (side, side))}
    return panel(SHADER, domain, {"kind": kind}, cell=at)


def furthest(level):
    """How far the two lower panels are from their formulas in float64."""
    apart = []
    for kind in (2, 3):
        steps = CELLS[kind] * (np.arange(20) + 0.5) / 20.0
        place = np.stack(np.meshgrid(steps - 2.0, steps - 1.0), -1).reshape(-1, 2)
        seen = level[:20, 20 * (kind - 2) :][:, :20].reshape(-1, 1)
        apart.append(np.abs(seen - np.asarray(LEVELS[kind](place))).max())
    return np.max(apart)


def largest(level):
    """The largest value on either side of 0."""
    return np.abs(level).max()


def gradient(name, origin, side, size):
    """A pass of gradient noise over a square of cells."""
    domain = {"place": rectangle((origin, origin), (side, side))}
    target = {"size": (size, size), "colors": {"level": "r32f"}}
    return panel_pass(name, SHADER, domain, {"kind": 1}, **target)


# Given exactly: a place that is interpolated may be a last bit beside, where noise is not 0.
LATTICE = ((0.0, 0.0), (3.0, 1.0), (-4.0, 2.0), (-1.0, -7.0), (30.0, -31.0), (12.0, 25.0))
HASHES = np.array([pcg_by_hand(k * 2654435761 % 2**32) for k in range(289)])
PERMUTED = np.array([(34 * k + 1) * k % 289 for k in range(289)])

case = Case(
    title="Noise",
    section="15.6",
    math=r"n(p) = \operatorname{mix}\ g_{ij} \cdot (p - p_{ij}), \qquad "
    r"f(t) = 6 t^5 - 15 t^4 + 10 t^3, \qquad |n| \le \sqrt{N / 4}",
    passes=(
        *enlarged([noise(k, cell(k, 2, 2, from_above=True)) for k in range(4)], (40, 40), 9),
        panel_pass("hash", "ch15_beyond/noise_hash.frag", {}, size=(289, 1)),
        gradient("wide", -32.0, 64.0, 256),
    ),
    picture="picture.FragColor",
    rows=("value, gradient", "octaves, marble"),
    expect=[
        *(formula("small.level", law, draw=k, name=KINDS[k]) for k, law in enumerate(LEVELS[:2])),
        measure(
            "octaves and marble, from the same in float64",
            furthest,
            reads={"level": "small.level"},
            at_most=2.0**-14,
            note="lattice points may be on either side; there noise is smooth, and bands are not",
        ),
        formula("small.FragColor", coast(value_noise), draw=0, name="in the colours of a coast"),
        enlarged_check(),
        exact("hash.hashed", HASHES[None, :, None], name="PCG"),
        exact("hash.permuted", 1.0 * PERMUTED[None, :, None], name="(34x + 1)x mod 289"),
        *figures(
            "wide.level",
            {f"at the lattice point {point}": ({"place": point}, 0.0) for point in LATTICE},
            digits=9,
        ),
        measure("its largest value", largest, reads={"level": "wide.level"}, between=(0.6, BOUND)),
        *results(
            {
                "numbers that (34x + 1)x mod 289 never gives": (289 - len(set(PERMUTED)), 0),
                "turns by which fract(sin(…)) may be off": (43758.5453 / 2**11, 21.366477),
            }
        ),
    ],
)
