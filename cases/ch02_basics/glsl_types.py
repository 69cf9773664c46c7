"""Vectors of every kind: float, bool, int and uint go in as uniforms and come out bit for bit.

A `vec` has two, three or four floats of 32 bits, `bvec`, `ivec` and `uvec` as many booleans,
integers and unsigned integers. A fragment shader may write floats and both kinds of integers; a
boolean must be converted first, and `int(true)` is 1. Doubles came with GLSL 4.00: in 3.30 the word
`dvec2` is reserved, and a shader that uses it does not compile.

Look at: the bits, the highest at the left. From above, four rows each of bool, float, int and uint.
Bright is 1. A float has a sign (red), eight bits of exponent (green) and 23 of fraction (blue): of
1, 2, −0.5 and 0.1 only the last has anything in its fraction, and there the pattern 1001 repeats,
because a tenth is no sum of powers of two. −1 as an int is the same 32 ones as the largest uint.

Try: in `ch02_basics/glsl_types_bits.frag` write `uint(-integers[component])` for
`uint(integers[component])`: 1 and −1 change places, and the row of 32 ones keeps a single bit.
"""

import numpy as np

from shaderlab import (
    Case,
    Erratum,
    Output,
    Target,
    Variant,
    boundaries,
    compile_fails,
    exact,
    formula,
    fullscreen,
)
from shaderlab.glslmath import floor, fract, max, min, mix, swizzle, vec3, vec4, where
from shaderlab.glslmath.sampling import texelFetch

from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import enlarged, panel, rectangle

TRUTHS = (True, False, False, True)
REALS = (1.0, 2.0, -0.5, 0.1)
INTEGERS = (1, -1, 2**31 - 1, -(2**31))
NATURALS = (1, 2**32 - 1, 2**31, 0xCAFE)
DOUBLES = (0.1, -1.0 / 3.0)
OTHERS = (
    (False, True, True, False),
    (3.4028234663852886e38, -0.0, 1.1754943508222875e-38, 16777217.0),
    (-16777217, 0, 65536, -65537),  # the first of each is no float
    (16777217, 7, 65536, 4294967294),
)


def halves(*numbers):
    """Each double's low and high 32 bits, as `unpackDouble2x32` gives them."""
    return np.array(numbers, "<f8").view("<u4")


def bits():
    """Every word's bits, 32 columns from the highest, 16 rows from the lowest one up."""
    words = np.concatenate(
        [
            np.array(TRUTHS, np.uint32),
            np.array(REALS, np.float32).view(np.uint32),
            np.array(INTEGERS, np.int32).view(np.uint32),
            np.array(NATURALS, np.uint32),
        ]
    )
    table = (words[:, None] >> np.arange(31, -1, -1, dtype=np.uint32)) & 1
    return table[::-1, :, None].astype(np.uint32)


FIELD = {"field": rectangle((0.0, 0.0), (32.0, 16.0))}
BITS = (
    *fullscreen(
        "ch02_basics/glsl_types_bits.frag",
        name="bits",
        domain=FIELD,
        uniforms={"truths": TRUTHS, "reals": REALS, "integers": INTEGERS, "naturals": NATURALS},
        target=Target(size=(32, 16)),
    ),
    *enlarged(
        [
            panel(
                "ch02_basics/glsl_types_picture.frag", FIELD, textures={"bits": Output("bits.bit")}
            )
        ],
        (224, 112),
        5,
    ),
)
RED, GREEN, BLUE = vec3(0.90, 0.35, 0.30), vec3(0.40, 0.75, 0.45), vec3(0.45, 0.60, 0.95)


def painted(bits, field):
    """Bright where a bit is 1: the four rows of each type in its own colours."""
    x, y = swizzle(field, "x"), swizzle(field, "y")
    real = where(x < 1.0, RED, where(x < 9.0, GREEN, BLUE))
    whole = where(x < 1.0, RED, vec3(0.75, 0.55, 0.90))
    hue = where(y > 12.0, vec3(0.95, 0.75, 0.30), real)
    hue = where(y < 8.0, whole, hue)
    hue = where(y < 4.0, vec3(0.35, 0.75, 0.80), hue)
    bit = swizzle(texelFetch(bits, floor(field)), "r")
    left, below = fract(x), fract(y)
    gap = (min(left, below) < 0.08) | (max(left, below) > 0.92)
    gap = gap | (y - 4.0 * floor(y / 4.0) < 0.16)
    hue = hue * where(bit > 0.5, 1.0, 0.24)
    return vec4(mix(vec3(0.07, 0.08, 0.10), hue, where(gap, 0.0, 1.0)), 1.0)


def handed_through(kind, name, uniforms):
    """A pass that hands its uniforms through."""
    shader = f"ch02_basics/glsl_types_{kind}.frag"
    return fullscreen(shader, name=name, domain={}, uniforms=uniforms)


def vectors(prefix, values):
    """The first two, three and all four components, as uniforms."""
    names = ("pair", "triple", "quad") if prefix is None else [f"{prefix}{n}" for n in (2, 3, 4)]
    return {name: values[:n] for name, n in zip(names, (2, 3, 4), strict=True)}


def passes(truths, reals, signed, unsigned):
    """Floats and booleans, and both kinds of integers."""
    floats = {**vectors("truths", truths), **vectors(None, reals)}
    integers = {**vectors(None, signed), **vectors("natural", unsigned)}
    return (
        *handed_through("float", "floats", floats),
        *handed_through("int", "integers", integers),
        *BITS,
    )


def unchanged(truths, reals, signed, unsigned):
    """Each output is its uniform."""
    return [
        exact(f"{pass_name}.{name}Out", values, name=f"{kind}{n}")
        for pass_name, prefix, kind, sent in (
            ("floats", None, "vec", np.float32(reals)),
            ("floats", "truths", "bvec", np.int32(truths)),
            ("integers", None, "ivec", np.int32(signed)),
            ("integers", "natural", "uvec", np.uint32(unsigned)),
        )
        for n, (name, values) in enumerate(vectors(prefix, sent).items(), 2)
    ]


case = Case(
    title="The types of GLSL",
    section="2.3.2",
    math=r"(-1)^{s} \cdot 2^{e - 127} \cdot \left(1 + \tfrac{f}{2^{23}}\right)",
    passes=passes(TRUTHS, REALS, INTEGERS, NATURALS),
    picture="picture.FragColor",
    rows=("bool", "float", "int", "uint"),
    expect=[
        exact("bits.bit", bits(), name="the bits of all sixteen words"),
        formula("small.FragColor", painted, name="the bits on show"),
        boundaries("small.FragColor", painted, name="… at their edges"),
        enlarged_check(),
    ],
    variants=[
        Variant(
            "ones and extremes",
            expect=[
                *unchanged(TRUTHS, REALS, INTEGERS, NATURALS),
                compile_fails(
                    "ch02_basics/errata/double_in_330.frag",
                    (2, "'dvec2' : Reserved word."),
                    (
                        2,
                        "'double vector' : not supported for this version or the enabled "
                        "extensions",
                    ),
                    name="dvec2 in 3.30 is refused",
                ),
            ],
        ),
        Variant("others", passes=passes(*OTHERS), expect=unchanged(*OTHERS)),
        Variant(
            "doubles, GLSL 4.00",
            passes=(
                *handed_through("double", "doubles", {"real": DOUBLES[0], "pair": DOUBLES}),
                *BITS,
            ),
            expect=[
                exact("doubles.realOut", halves(DOUBLES[0]), name="double"),
                exact("doubles.pairOut", halves(*DOUBLES), name="dvec2"),
            ],
        ),
    ],
    errata=[
        Erratum(
            section="2.3.2",
            says="the table of vector types has dvecn, n doubles, and names no version",
            truth="double, dvec2, dvec3 and dvec4 need #version 400; in 330, which the notes' "
            "shaders are written in, the words are reserved",
            proof="dvec2 in 3.30 is refused",
        )
    ],
)
